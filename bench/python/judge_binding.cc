#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "core/criterion/impulse_verdict.h"

namespace bipot {
namespace {

namespace py = pybind11;

using HeldVerdict = std::shared_ptr<ImpulseVerdict>;
using HeldContact = std::shared_ptr<JudgedContact>;

HeldVerdict judge_impulse(const PythonProblem& problem, const py::object& s, int worst) {
  const Vector x = to_vector(s, "s");
  const py::gil_scoped_release release;
  auto verdict = std::make_shared<ImpulseVerdict>(judge(*problem.problem, x, worst));
  verdict->caution = problem.caution;
  return verdict;
}

py::list faults_of(const JudgedContact& contact) {
  py::list faults;
  for (const ContactFault& fault : contact.faults) {
    faults.append(py::dict(py::arg("kind") = to_string(fault.kind), py::arg("size") = fault.size,
                           py::arg("energy") = fault.energy));
  }
  return faults;
}

void bind_contact(py::module_& module) {
  py::class_<JudgedContact, HeldContact> bound(module, "JudgedContact",
                                               "A contact that breaks the law; str() says how.");
  refuse_new(bound);
  bound.def_readonly("contact", &JudgedContact::contact, "Its number.")
      .def_readonly("mu", &JudgedContact::mu, "Physical friction coefficient.")
      .def_property_readonly(
          "s", [](const HeldContact& c) { return view_of(c->s, py::cast(c)); },
          "(d,) as given, physical [N s].")
      .def_property_readonly(
          "u", [](const HeldContact& c) { return view_of(c->u, py::cast(c)); },
          "(d,) physical [m/s].")
      .def_readonly("share", &JudgedContact::share, "Of all contacts' violation, 0 to 1.")
      .def_property_readonly(
          "faults", &faults_of,
          R"(kind ("pulls", "outside the cone", "penetrates", "acts across a gap", "slides inside the
cone", "friction does not oppose"), size [N s or m/s], energy [J]; the largest energy first.)")
      .def("__str__", [](const JudgedContact& c) { return sentence(c); })
      .def("__repr__",
           [](const JudgedContact& c) { return fmt::format("<bipot {}>", sentence(c)); });
}

}  // namespace

void bind_judge(py::module_& module) {
  bind_contact(module);
  const auto of_error = [](auto ContactError::*field) {
    return [field](const ImpulseVerdict& v) { return v.error.*field; };
  };
  py::class_<ImpulseVerdict, HeldVerdict> verdict(module, "Verdict",
                                                  "What can be said of an impulse, see `judge`.");
  refuse_new(verdict);
  verdict
      .def_property_readonly("epsilon", of_error(&ContactError::epsilon),
                             "Guarded form of the paper's (42).")
      .def_property_readonly("eta", of_error(&ContactError::eta), "Natural map in energy.")
      .def_property_readonly("raw42", of_error(&ContactError::raw42),
                             "The paper's (42); nan where nothing slides.")
      .def_property_readonly("natural_map", of_error(&ContactError::natural_map),
                             "Relative, scaled contact by contact: no units.")
      .def_readonly("siconos_map", &ImpulseVerdict::siconos_map,
                    "Relative, in the normalisation of Siconos: depends on units.")
      .def_readonly("cone", &ImpulseVerdict::cone,
                    "Distance of s to the friction cone, in the measure of eta; 0 inside.")
      .def_property_readonly("guarded", &ImpulseVerdict::guarded,
                             "max(epsilon, eta, cone), in higher precision where rounding decides.")
      .def_readonly("cone_violation", &ImpulseVerdict::cone_violation,
                    "Largest distance of one contact's impulse to its cone [N s].")
      .def_property_readonly(
          "cone_contact", [](const ImpulseVerdict& v) { return contact_or_none(v.cone_contact); },
          "Where cone_violation is; None: nowhere.")
      .def_readonly("penetration_velocity", &ImpulseVerdict::penetration_velocity,
                    "Largest approach that is left [m/s].")
      .def_property_readonly(
          "penetration_contact",
          [](const ImpulseVerdict& v) { return contact_or_none(v.penetration_contact); },
          "Where penetration_velocity is; None: nowhere.")
      .def_property_readonly(
          "take_off", [](const ImpulseVerdict& v) { return v.count.take_off; },
          "Contacts without impulse.")
      .def_property_readonly(
          "stick", [](const ImpulseVerdict& v) { return v.count.stick; },
          "Contacts inside the cone.")
      .def_property_readonly(
          "slip", [](const ImpulseVerdict& v) { return v.count.slip; }, "Contacts on its edge.")
      .def_property_readonly(
          "worst",
          [](const ImpulseVerdict& v) {
            py::list worst;
            for (const JudgedContact& c : v.worst) worst.append(std::make_shared<JudgedContact>(c));
            return worst;
          },
          "From the worst down, copies; none without a fault.")
      .def_property_readonly(
          "worst_contact",
          [](const ImpulseVerdict& v) {
            return contact_or_none(v.worst.empty() ? -1 : v.worst.front().contact);
          },
          "The first of worst; None without one.")
      .def_property_readonly(
          "s", [](const HeldVerdict& v) { return view_of(v->s, py::cast(v)); },
          "(m,) projected on the cone [N s]; a read-only view.")
      .def_property_readonly(
          "u", [](const HeldVerdict& v) { return view_of(v->u, py::cast(v)); },
          "(m,) W s + u_free of it [m/s]; a read-only view.")
      .def(
          "within",
          [](const ImpulseVerdict& v, const py::object& tol) {
            return v.guarded() <= to_number(tol, "tol");
          },
          py::arg("tol"), "guarded <= tol.")
      .def(
          "sentence",
          [](const ImpulseVerdict& v, const py::object& tol) {
            const double within = to_number(tol, "tol");
            if (!(within > 0 && std::isfinite(within))) {
              throw std::invalid_argument(
                  fmt::format("tol = {}: expected a positive number", within));
            }
            return sentence(v, within);
          },
          py::arg("tol"), "As `bipot judge` says it.")
      .def("__repr__", [](const ImpulseVerdict& v) {
        return fmt::format("<bipot.Verdict: ε {:.2e}, η {:.2e}, cone {:.2e}{}{}>", v.error.epsilon,
                           v.error.eta, v.cone,
                           v.worst.empty() ? "" : "; " + sentence(v.worst.front()),
                           v.caution.empty() ? "" : "; " + v.caution);
      });
  module.def("judge", &judge_impulse, py::arg("problem"), py::arg("s"), py::arg("worst"));
}

}  // namespace bipot
