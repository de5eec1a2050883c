#include <string>

#include "core/run_files/frame_entries.h"

namespace bipot {
namespace {

struct Description {
  const char *name, *text;
};

constexpr Description kDatasets[] = {
    {"/gravity", "acceleration of gravity"},
    {"/time_step", "size h of a step"},
    {"/accuracy", "radii by which an impact may misplace a body; absent: none was asked for"},
    {"/measured", "what the observables are; a restart must have the same"},
    {"/contact_distance", "bodies closer than this at mid-step are candidates for a contact"},
    {"/dem/stiffness", "of a contact spring along n"},
    {"/dem/tangential_stiffness", "of a contact spring along t"},
    {"/dem/substep", "time step of the spring-dashpot model"},
    {"/dem/critical_step", "largest stable time step of the stiffest pair"},
    {"/bodies/radius", "of each body"},
    {"/bodies/mass", "of each body; disks are cylinders 1 m long where a density is given"},
    {"/bodies/inertia", "moment of inertia about the centre"},
    {"/bodies/material", "index into /materials"},
    {"/bodies/wall", "index of the wall to which the body is glued, -1: none"},
    {"/bodies/number", "number of the body in the scene; new bodies follow"},
    {"/bodies/x", "centre, after the step"},
    {"/bodies/v", "velocity after the step; the third component is 0 in 2D"},
    {"/bodies/angle", "turned since the start, positive counter-clockwise"},
    {"/bodies/orientation", "unit quaternion w, x, y, z"},
    {"/bodies/spin", "angular velocity, in 2D positive counter-clockwise"},
    {"/bodies/stress", "mean stress in the body, positive in compression: xx, xy, xz, yy, yz, zz"},
    {"/bodies/pressure", "mean of the principal stresses of the body, positive in compression"},
    {"/bodies/cluster", "index of the cluster of the body, -1: none"},
    {"/bodies/arm", "initial vector from the centre of mass of the cluster"},
    {"/bodies/x_in_cell", "centre in the periodic cell"},
    {"/clusters/x", "centre of mass"},
    {"/clusters/v", "velocity of the centre of mass"},
    {"/clusters/angle", "turned since the start"},
    {"/clusters/spin", "angular velocity"},
    {"/clusters/mass", "of the cluster"},
    {"/clusters/orientation", "rotation since the start, unit quaternion w, x, y, z"},
    {"/clusters/inertia", "about the centre of mass; in 3D the principal moments"},
    {"/clusters/axes", "turns the axes of space to the principal ones at the start, w, x, y, z"},
    {"/clusters/area", "of the union of its disks"},
    {"/clusters/volume", "of the union of its spheres"},
    {"/walls/name", "in the order of the scene; contacts name wall k by j = n + k with n bodies"},
    {"/walls/shape",
     "0 half-plane, 1 segment, 2 hollow circle, 3 solid circle; in 3D 0 half-space, 2 hollow and 3 solid cylinder, 4 triangles, 5 cone"},
    {"/walls/motion", "0 fixed, 1 prescribed velocity, 2 driven by a force"},
    {"/walls/material", "index into /materials"},
    {"/walls/normal", "unit normal, towards the bodies; of a cylinder its axis"},
    {"/walls/direction", "of the force and motion of a driven wall"},
    {"/walls/force", "that drives the wall along its direction"},
    {"/walls/mass", "of a driven wall"},
    {"/walls/radius", "of a circle or cylinder; of a cone at its point a"},
    {"/walls/radius_b", "of a cone at its point b"},
    {"/walls/triangles", "number of triangles of each wall"},
    {"/walls/triangle", "corners of the triangles relative to the point a of their wall"},
    {"/walls/spin", "of a circle or cylinder about its axis"},
    {"/walls/belt", "velocity of the surface of a belt"},
    {"/walls/across", "velocity of a driven wall across its direction"},
    {"/walls/a", "point of the wall: on the plane, first end, centre"},
    {"/walls/b", "second end of a segment"},
    {"/walls/v", "velocity of the wall as a whole"},
    {"/walls/rim", "closed polygons that draw circles"},
    {"/walls/present", "0: the wall has been removed"},
    {"/cell/stress", "that drives the sides: width, height, offset"},
    {"/cell/mass", "of the sides: width, height, offset"},
    {"/cell/lengths", "width, height, offset; in 3D width, depth"},
    {"/cell/speeds", "rates of the lengths; of the offset without what a driven width carries"},
    {"/time", "after the step"},
    {"/wall_work", "work of moving and driven walls since step 0"},
    {"/friction_loss", "dissipated by tangential impulses since step 0"},
    {"/shock_loss", "dissipated by normal impulses since step 0"},
    {"/halvings", "the next step begins with 2^halvings parts: --on-failure smaller-step"},
    {"/cohesion_loss", "taken by cohesion since step 0, less what it gave"},
    {"/outlets/count", "bodies that left since step 0"},
    {"/outlets/mass", "that left since step 0"},
    {"/outlets/energy", "kinetic and potential, at the time they left"},
    {"/outlets/momentum", "that left since step 0"},
    {"/outlets/last_mass", "that left in this step"},
    {"/inlets/count", "bodies that came in since step 0"},
    {"/inlets/waiting", "steps without room for a body that was due"},
    {"/inlets/mass", "that came in since step 0"},
    {"/inlets/energy", "kinetic and potential, at the time they came in"},
    {"/inlets/momentum", "that came in since step 0"},
    {"/inlets/last_mass", "that came in in this step"},
    {"/contacts/i", "first body of the contact, a row of /bodies; forces act on it"},
    {"/contacts/j",
     "second body if j < n, with n the number of bodies; else wall j - n, a row of /walls"},
    {"/contacts/status", "0 open (take-off, no impulse but cohesion), 1 stick, 2 slip"},
    {"/contacts/n", "unit normal, from j to i"},
    {"/contacts/gap", "at mid-step, negative: overlap; in the model dem after the step"},
    {"/contacts/s_n",
     "normal impulse of the step on body i, > 0: pushes apart, < 0: cohesion holds"},
    {"/contacts/s_t",
     "tangential impulse of the step on body i; in 2D along t = n turned by +90 degrees, in 3D a vector across n"},
    {"/contacts/u_n", "normal relative velocity of i to j after the step, > 0: opens"},
    {"/contacts/u_t",
     "tangential relative velocity of i to j after the step; in 2D along t = n turned by +90 degrees, in 3D a vector across n"},
    {"/contacts/force_n", "s_n over the time step"},
    {"/contacts/force_t", "s_t over the time step"},
    {"/contacts/force", "force on body i, (s_n n + s_t t) over the time step; on j the opposite"},
    {"/contacts/point", "point of contact on the surface of body i"},
    {"/contacts/bonded", "1: cohesion acted in the step"},
    {"/contacts/moment", "moment of rolling friction on body i, over the step; on j the opposite"},
    {"/contacts/spring", "elongation of the tangential spring"},
    {"/contacts/image_x", "periods in x from j to its image in the contact"},
    {"/contacts/image_y", "periods in y from j to its image in the contact"},
    {"/sample/area", "of the sample, over which stresses are means"},
    {"/sample/volume", "of the sample, over which stresses are means"},
    {"/sample/contact_stress", "mean stress by contacts, rows: force, columns: normal"},
    {"/sample/kinetic_stress", "mean stress by velocity fluctuations"},
    {"/sample/spin_stress", "mean stress by angular accelerations"},
};

// In /observables, and there in groups of their own.
constexpr Description kObservables[] = {
    {"disks", "bodies in the window"},
    {"spheres", "bodies in the window"},
    {"rattlers", "bodies with fewer than two loaded contacts with others than rattlers"},
    {"contacts", "loaded contacts"},
    {"sliding_share", "share of the loaded contacts on the edge of the cone"},
    {"coordination", "mean number of loaded contacts of a body"},
    {"coordination_without_rattlers", "the same without rattlers"},
    {"solid_fraction", "area or volume of bodies over that of the window"},
    {"pressure", "mean of the principal stresses"},
    {"shear_rate", "of the velocity gradient that fits the bodies best"},
    {"mean_mass", "of a body"},
    {"mean_diameter", "of spheres of the same volumes"},
    {"density", "of the bodies"},
    {"inertial_number", "shear rate in units of pressure and size"},
    {"friction", "shear over mean stress"},
    {"position", "middle of the bin"},
    {"spin", "mean of the bin"},
    {"temperature", "mean square of velocity fluctuations over the dimension"},
    {"mean", "mean normal force of loaded contacts"},
};

std::string observable_text(const std::string& name) {
  for (const Description& d : kObservables) {
    if (name == d.name) return d.text;
  }
  if (name.starts_with("fabric_")) return "mean of n x n over loaded contacts";
  if (name.starts_with("stress_")) return "mean stress, positive in compression";
  if (name.starts_with("v")) return "mean velocity of the bin";
  return "mean spin of the bin";
}

}  // namespace

void add_descriptions(Hdf5File& file) {
  for (const Description& d : kDatasets) {
    if (file.exists(d.name)) file.write_attribute(d.name, "description", d.text);
  }
  if (!file.exists("/observables")) return;
  const auto describe = [&](const std::string& group, const auto& text_of) {
    if (!file.exists(group)) return;
    for (const std::string& name : file.list(group)) {
      if (name == "forces" || name == "flux" || name == "profile") continue;
      file.write_attribute(group + "/" + name, "description", text_of(name));
    }
  };
  describe("/observables", observable_text);
  describe("/observables/profile", observable_text);
  describe("/observables/flux", [](const std::string&) {
    return std::string("mass flux across the line or face, in its direction");
  });
  file.write_attribute("/observables/forces/counts", "description",
                       "loaded contacts in bins of equal width from 0 to the limit");
  file.write_attribute("/observables/forces/mean", "description", observable_text("mean"));
  file.write_attribute("/observables/forces/limit", "description",
                       "upper end of the last bin, over the mean force");
}

}  // namespace bipot
