#include "core/problem_files/fclib_file.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/file_error.h"
#include "core/base/triplets.h"
#include "core/files/atomic_file.h"
#include "core/files/hdf5_file.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"
#include "core/problem_files/problem_form.h"

namespace bipot {
namespace {

constexpr int kCompressedColumns = -1;
constexpr int kCompressedRows = -2;
constexpr const char* kLenient = "/bipot/lenient";

std::span<const double> span(const Vector& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

Vector read_vector(const Hdf5File& file, const std::string& name) {
  const std::vector<double> values = file.read_doubles(name);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k])) continue;
    throw FileError(file.path(), name, fmt::format("element {} = {} is not finite", k, values[k]));
  }
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::string read_optional_string(const Hdf5File& file, const std::string& name) {
  return file.exists(name) ? file.read_string(name) : std::string();
}

StoredEntries read_matrix(const Hdf5File& file, const std::string& group) {
  const auto refuse = [&](const std::string& reason) {
    throw FileError(file.path(), group, reason);
  };
  if (!file.exists(group)) refuse("missing");
  StoredEntries matrix{.rows = file.read_int(group + "/m"), .columns = file.read_int(group + "/n")};
  const int nz = file.read_int(group + "/nz");
  if (matrix.rows < 0 || matrix.columns < 0) {
    refuse(fmt::format("m = {}, n = {}", matrix.rows, matrix.columns));
  }
  if (nz < kCompressedRows) {
    refuse(
        fmt::format("nz = {} is neither a number of triplets nor -1 (columns) nor -2 (rows)", nz));
  }
  const std::vector<int> p = file.read_ints(group + "/p");
  const std::vector<int> i = file.read_ints(group + "/i");
  const std::vector<double> x = file.read_doubles(group + "/x");

  const auto add = [&](int row, int column, std::size_t k) {
    if (row < 0 || row >= matrix.rows || column < 0 || column >= matrix.columns) {
      refuse(fmt::format("entry {} at ({}, {}) of a {} x {} matrix", k, row, column, matrix.rows,
                         matrix.columns));
    }
    if (!std::isfinite(x[k])) {
      refuse(fmt::format("entry {} at ({}, {}) = {} is not finite", k, row, column, x[k]));
    }
    matrix.entries.emplace_back(row, column, x[k]);
  };
  const auto require_length = [&](const char* name, std::size_t have, std::size_t need) {
    if (have < need) refuse(fmt::format("{} has {} elements, {} are needed", name, have, need));
  };
  if (nz >= 0) {
    const auto count = static_cast<std::size_t>(nz);
    require_length("p", p.size(), count);
    require_length("i", i.size(), count);
    require_length("x", x.size(), count);
    for (std::size_t k = 0; k < count; ++k) add(i[k], p[k], k);
    return matrix;
  }
  const bool by_rows = nz == kCompressedRows;
  const int lines = by_rows ? matrix.rows : matrix.columns;
  require_length("p", p.size(), static_cast<std::size_t>(lines) + 1);
  if (p[0] != 0) refuse(fmt::format("p[0] = {}, expected 0", p[0]));
  for (std::size_t line = 0; line < to_size(lines); ++line) {
    if (p[line + 1] < p[line]) {
      refuse(
          fmt::format("p[{}] = {} is less than p[{}] = {}", line + 1, p[line + 1], line, p[line]));
    }
  }
  const auto count = to_size(p[to_size(lines)]);
  require_length("i", i.size(), count);
  require_length("x", x.size(), count);
  for (int line = 0; line < lines; ++line) {
    const std::size_t end = to_size(p[to_size(line) + 1]);
    for (std::size_t k = to_size(p[to_size(line)]); k < end; ++k) {
      add(by_rows ? line : i[k], by_rows ? i[k] : line, k);
    }
  }
  return matrix;
}

bool has_entries(const Hdf5File& file, const std::string& matrix) {
  return file.exists(matrix) && file.read_int(matrix + "/m") > 0 &&
         file.read_int(matrix + "/n") > 0;
}

/// Checks sizes before the matrix is built: a wrong size could exhaust the memory.
void require_shape(const Hdf5File& file, const std::string& group, const StoredEntries& matrix,
                   Eigen::Index rows, Eigen::Index columns) {
  if (matrix.rows == rows && matrix.columns == columns) return;
  throw FileError(file.path(), group,
                  fmt::format("is {} x {}, expected {} x {} from spacedim and the sizes of the "
                              "vectors",
                              matrix.rows, matrix.columns, rows, columns));
}

Vector every_other(const Vector& x) {
  return Eigen::Map<const Vector, 0, Eigen::InnerStride<2>>(x.data(), x.size() / 2);
}

/// Adds the equality rows of a global problem, if the file has any.
void add_equality_rows(const Hdf5File& file, const std::string& root, int stored_dofs,
                       ContactProblem& problem) {
  const std::string group = root + "/G", vector = root + "/vectors/b";
  const Vector b = file.exists(vector) ? read_vector(file, vector) : Vector();
  if (!has_entries(file, group) && b.size() == 0) return;
  const StoredEntries stored = read_matrix(file, group);
  require_shape(file, group, stored, stored_dofs, b.size());
  SparseRows G = SparseRows(stored.build<SparseMatrix>().transpose());
  G.conservativeResize(G.rows(), problem.num_dofs());  // without those of inert tangents
  try {
    problem = with_equality_rows(std::move(problem), std::move(G), -b, file.exists(kLenient));
  } catch (const std::invalid_argument& e) {
    throw FileError(file.path(), group, e.what());
  }
}

/// Rows with the tangential rows of with_inert_tangents() inserted as zeros.
Vector spread(const Vector& x) {
  Vector y = Vector::Zero(2 * x.size());
  Eigen::Map<Vector, 0, Eigen::InnerStride<2>>(y.data(), x.size()) = x;
  return y;
}

/// Body velocities with those of inert tangents, which stand still.
Vector stored_velocities(const ContactProblem& p, const Vector& v) {
  Vector x = Vector::Zero(v.size() + (p.dim == 1 ? p.num_contacts() : 0));
  x.head(v.size()) = v;
  return x;
}

/// Inverse of the spacedim-2 form of a frictionless problem, see the header.
ContactProblem without_tangents(const ContactProblem& p, int dofs) {
  ContactProblem q{.dim = 1, .u_free = every_other(p.u_free), .mu = p.mu};
  const int contacts = p.num_contacts();
  Triplets entries;
  if (p.has_velocities()) {
    q.v_free = p.v_free.head(dofs);
    q.A = p.A.topLeftCorner(dofs, dofs);
    for (int c = 0; c < contacts; ++c) {
      for (SparseMatrix::InnerIterator it(p.H, 2 * c); it; ++it) {
        if (it.row() < dofs) entries.emplace_back(static_cast<int>(it.row()), c, it.value());
      }
    }
    q.H = from_triplets(dofs, contacts, entries);
    if (p.has_delassus()) q.W = assemble_delassus(q.A, q.H, 1);
  } else {
    for (int c = 0; c < contacts; ++c) {
      for (SparseRows::InnerIterator it(p.W, 2 * c); it; ++it) {
        if (it.col() % 2 == 0) entries.emplace_back(c, static_cast<int>(it.col()) / 2, it.value());
      }
    }
    q.W = from_triplets<SparseRows>(contacts, contacts, entries);
  }
  return q;
}

/// The spacedim-2 form of a frictionless problem, see the header.
ContactProblem with_inert_tangents(const ContactProblem& p) {
  const int contacts = p.num_contacts();
  const int dofs = p.num_dofs();
  const Vector w_nn = DelassusOperator(p).diagonal();
  ContactProblem q{.dim = 2, .u_free = spread(p.u_free), .mu = Vector::Zero(contacts)};
  if (p.has_velocities()) {
    Triplets mass, wrench;
    append_entries(p.A, mass);
    append_entries(p.H, wrench, 1, 2);
    for (int c = 0; c < contacts; ++c) {
      mass.emplace_back(dofs + c, dofs + c, 1 / w_nn[c]);
      wrench.emplace_back(dofs + c, 2 * c + 1, 1.0);
    }
    q.A = from_triplets(dofs + contacts, dofs + contacts, mass);
    q.H = from_triplets(dofs + contacts, 2 * contacts, wrench);
    q.v_free = stored_velocities(p, p.v_free);
  } else {
    Triplets entries;
    append_entries(p.W, entries, 2, 2);
    for (int c = 0; c < contacts; ++c) entries.emplace_back(2 * c + 1, 2 * c + 1, w_nn[c]);
    q.W = from_triplets<SparseRows>(2 * contacts, 2 * contacts, entries);
  }
  return q;
}

template <class Sparse>
void write_matrix(Hdf5File& file, const std::string& group, Sparse matrix) {
  matrix.makeCompressed();
  const auto count = static_cast<std::size_t>(matrix.nonZeros());
  file.write(group + "/nzmax", static_cast<int>(count));
  file.write(group + "/m", static_cast<int>(matrix.rows()));
  file.write(group + "/n", static_cast<int>(matrix.cols()));
  file.write(group + "/nz", Sparse::IsRowMajor ? kCompressedRows : kCompressedColumns);
  file.write(group + "/p", std::span<const int>(matrix.outerIndexPtr(),
                                                static_cast<std::size_t>(matrix.outerSize()) + 1));
  file.write(group + "/i", std::span<const int>(matrix.innerIndexPtr(), count));
  file.write(group + "/x", std::span<const double>(matrix.valuePtr(), count));
}

/// Writes guesses in FCLIB's form: number_of_guesses, and a group 1, 2, ... with u, r (and v) for
/// each.
void write_guesses(Hdf5File& file, const ContactProblem& p, const std::vector<Vector>& guesses) {
  if (guesses.empty()) return;
  const bool frictionless = p.dim == 1;
  file.write("/guesses/number_of_guesses", static_cast<int>(guesses.size()));
  const DelassusOperator delassus(p);
  for (std::size_t k = 0; k < guesses.size(); ++k) {
    const std::string group = fmt::format("/guesses/{}", k + 1);
    const Vector& r = guesses[k];
    Vector u;
    delassus.velocity(r, u);
    if (p.has_velocities()) {
      file.write(group + "/v", span(stored_velocities(p, body_velocities(p, r))));
    }
    file.write(group + "/u", span(frictionless ? spread(u) : u));
    file.write(group + "/r", span(frictionless ? spread(r) : r));
  }
}

/// Sizes of a problem as in the file.
struct Stored {
  int rows = 0;
  int dofs = 0;  // global form only
};

/// True for the groups of problems with rolling friction.
bool is_rolling(const std::string& root) { return root.starts_with("/bipot"); }

/// Reads the problem in the form that out.global says, with the file's spacedim.
Stored read_form(const Hdf5File& file, const std::string& root, int dim, ProblemFile& out) {
  Vector mu = read_vector(file, root + "/vectors/mu"), mu_r, mu_spin;
  if (is_rolling(root)) mu_r = read_vector(file, root + "/vectors/mu_r");
  if (is_rolling(root) && dim == 6) mu_spin = read_vector(file, root + "/vectors/mu_spin");
  const Eigen::Index rows = dim * mu.size();
  Stored stored;
  try {
    if (!out.global) {
      const StoredEntries W = read_matrix(file, root + "/W");
      require_shape(file, root + "/W", W, rows, rows);
      Vector q = read_vector(file, root + "/vectors/q");
      const std::string name = root + "/vectors/s";
      const Vector s = file.exists(name) ? read_vector(file, name) : Vector();
      if (s.size() > 0 || has_entries(file, root + "/V") || has_entries(file, root + "/R")) {
        if (is_rolling(root)) {
          throw std::invalid_argument("equality rows are not taken with rolling friction");
        }
        const StoredEntries V = read_matrix(file, root + "/V"), R = read_matrix(file, root + "/R");
        require_shape(file, root + "/V", V, rows, s.size());
        require_shape(file, root + "/R", R, s.size(), s.size());
        out.problem = from_local_form(dim, W.build<SparseRows>(), q, std::move(mu),
                                      V.build<SparseRows>(), R.build<SparseMatrix>(), s);
      } else {
        out.problem = from_local_form(dim, W.build<SparseRows>(), std::move(q), std::move(mu),
                                      std::move(mu_r), std::move(mu_spin));
      }
    } else {
      const StoredEntries M = read_matrix(file, root + "/M");
      const StoredEntries H = read_matrix(file, root + "/H");
      const Vector f = read_vector(file, root + "/vectors/f");
      require_shape(file, root + "/M", M, f.size(), f.size());
      require_shape(file, root + "/H", H, f.size(), rows);
      stored.dofs = M.rows;
      out.problem = from_global_form(dim, M.build<SparseMatrix>(), H.build<SparseMatrix>(), f,
                                     read_vector(file, root + "/vectors/w"), std::move(mu),
                                     std::move(mu_r), std::move(mu_spin));
    }
  } catch (const std::invalid_argument& e) {
    throw FileError(file.path(), root, e.what());
  }
  stored.rows = out.problem.num_rows();
  return stored;
}

/// Removes the tangents of a frictionless problem. Returns its number of degrees of freedom.
int restore_dim(const Hdf5File& file, int dim, int stored_dofs, ProblemFile& out) {
  if (!file.exists("/bipot/dim")) return stored_dofs;
  const int true_dim = file.read_int("/bipot/dim");
  const bool frictionless = true_dim == 1 && dim == 2;
  if (!frictionless && true_dim != dim) {
    throw FileError(file.path(), "/bipot/dim", fmt::format("{} with spacedim {}", true_dim, dim));
  }
  if (!frictionless) return stored_dofs;
  const int dofs = out.global ? file.read_int("/bipot/dofs") : stored_dofs;
  if (out.problem.mu.size() > 0 && out.problem.mu.maxCoeff() > 0) {
    throw FileError(file.path(), "/bipot/dim", "1, but there is friction");
  }
  if (out.global && dofs != stored_dofs - out.problem.num_contacts()) {
    throw FileError(
        file.path(), "/bipot/dofs",
        fmt::format("{} of {} with {} contacts", dofs, stored_dofs, out.problem.num_contacts()));
  }
  out.problem = without_tangents(out.problem, dofs);
  return dofs;
}

/// Reads reference solution and guesses, if the file has them.
void read_impulses(const Hdf5File& file, const Stored& stored, int dofs, ProblemFile& out) {
  // In the file a frictionless problem has tangents.
  const bool with_tangents = out.problem.num_rows() < stored.rows;
  const auto read_rows = [&](const std::string& name, int size) {
    Vector x = read_vector(file, name);
    if (x.size() != size) {
      throw FileError(file.path(), name,
                      fmt::format("has {} elements, expected {}", x.size(), size));
    }
    return x;
  };
  if (file.exists("/solution")) {
    out.r = read_rows("/solution/r", stored.rows);
    out.u = read_rows("/solution/u", stored.rows);
    if (with_tangents) {
      out.r = every_other(*out.r);
      out.u = every_other(*out.u);
    }
    if (out.global && file.exists("/solution/v")) {
      out.v = read_rows("/solution/v", stored.dofs).head(dofs).eval();
    }
  }
  if (file.exists("/guesses/number_of_guesses")) {
    const int guesses = file.read_int("/guesses/number_of_guesses");
    for (int k = 1; k <= guesses; ++k) {
      const Vector r = read_rows(fmt::format("/guesses/{}/r", k), stored.rows);
      out.guesses.push_back(with_tangents ? every_other(r) : r);
    }
  }
}

}  // namespace

ProblemFile read_fclib(const std::filesystem::path& path) {
  const Hdf5File file(path, Hdf5File::Mode::kRead);
  ProblemFile out;
  std::vector<std::string> roots;
  for (const char* name : {"/fclib_local", "/fclib_global", "/bipot_local", "/bipot_global"}) {
    if (file.exists(name)) roots.emplace_back(name);
  }
  if (roots.size() != 1) {
    throw FileError(path, "",
                    roots.empty()
                        ? "neither /fclib_local nor /fclib_global is present: not a problem"
                        : fmt::format("both {} and {} are present", roots[0], roots[1]));
  }
  const std::string& root = roots.front();
  out.global = root.ends_with("global");
  const int dim = file.read_int(root + "/spacedim");
  const int plane = is_rolling(root) ? 3 : 2, space = is_rolling(root) ? 6 : 3;
  if (dim != plane && dim != space) {
    throw FileError(path, root + "/spacedim",
                    fmt::format("{} is neither {} nor {}", dim, plane, space));
  }
  out.info.title = read_optional_string(file, root + "/info/title");
  out.info.description = read_optional_string(file, root + "/info/description");
  out.info.math_info = read_optional_string(file, root + "/info/math_info");
  const Stored stored = read_form(file, root, dim, out);
  const int dofs = restore_dim(file, dim, stored.dofs, out);
  if (file.exists("/bipot/row_scale")) {
    out.problem.row_scale = read_vector(file, "/bipot/row_scale");
  }
  if (std::string defect = validate(out.problem); !defect.empty()) {
    throw FileError(path, root, defect);
  }
  if (out.global) add_equality_rows(file, root, stored.dofs, out.problem);
  read_impulses(file, stored, dofs, out);
  return out;
}

void write_fclib(const std::filesystem::path& path, const ContactProblem& problem,
                 const ProblemInfo& info, const std::vector<Vector>& guesses) {
  if (std::string defect = validate(problem); !defect.empty()) {
    throw FileError(path, "", "refused to write: " + defect);
  }
  if (problem.num_contacts() == 0) throw FileError(path, "", "refused to write: no contacts");
  for (const Vector& r : guesses) {
    if (r.size() == problem.num_rows() && r.allFinite()) continue;
    throw FileError(path, "/guesses", "refused to write: of another size, or not finite");
  }
  const bool frictionless = problem.dim == 1;
  const ContactProblem& given = without_equality_rows(problem);
  const ContactProblem p = frictionless ? with_inert_tangents(given) : given;
  AtomicFile target(path);
  Hdf5File file(target.draft(), Hdf5File::Mode::kCreate);
  const std::string root =
      std::string(p.rolls() ? "/bipot" : "/fclib") + (p.has_velocities() ? "_global" : "_local");
  file.write(root + "/spacedim", p.dim);
  if (p.has_velocities()) {
    write_matrix(file, root + "/M", p.A);
    write_matrix(file, root + "/H", p.H);
    const Vector f = p.A * p.v_free;
    file.write(root + "/vectors/f", span(f));
    // With the v_free that a reader has of f: it gets this u_free again.
    Vector v_free;
    try {
      v_free = velocity_of(p.A, f);
    } catch (const std::invalid_argument& e) {
      throw FileError(path, "", std::string("refused to write: ") + e.what());
    }
    file.write(root + "/vectors/w", span(Vector(p.u_free - p.H.transpose() * v_free)));
  } else {
    write_matrix(file, root + "/W", p.W);
    file.write(root + "/vectors/q", span(p.u_free));
  }
  file.write(root + "/vectors/mu", span(p.mu));
  if (p.rolls()) file.write(root + "/vectors/mu_r", span(p.mu_r));
  if (p.mu_spin.size() > 0) file.write(root + "/vectors/mu_spin", span(p.mu_spin));
  file.write(root + "/info/title", info.title);
  file.write(root + "/info/description", info.description);
  file.write(root + "/info/math_info", info.math_info);
  if (frictionless) {
    file.write("/bipot/dim", 1);
    if (p.has_velocities()) file.write("/bipot/dofs", given.num_dofs());
  }
  if (problem.equality) {
    SparseMatrix G = SparseMatrix(problem.equality->G).transpose();
    G.conservativeResize(p.num_dofs(), G.cols());
    write_matrix(file, root + "/G", std::move(G));
    file.write(root + "/vectors/b", span(-problem.equality->b));
    if (problem.equality->lenient) file.write(kLenient, 1);
  }
  if (problem.row_scale.size() > 0) file.write("/bipot/row_scale", span(problem.row_scale));
  write_guesses(file, problem, guesses);
  file.close();
  target.commit();
}

void write_fclib_solution(const std::filesystem::path& path, const Vector& r, const Vector& u,
                          const std::optional<Vector>& v) {
  const ProblemFile stored = read_fclib(path);
  const ContactProblem& p = stored.problem;
  const auto check = [&](const char* name, const Vector& x, int size) {
    if (x.size() != size) {
      throw FileError(path, std::string("/solution/") + name,
                      fmt::format("refused to write {} elements, expected {}", x.size(), size));
    }
    if (!x.allFinite()) {
      throw FileError(path, std::string("/solution/") + name, "refused to write: not finite");
    }
  };
  check("r", r, p.num_rows());
  check("u", u, p.num_rows());
  std::optional<Vector> velocities = v;
  if (stored.global && !velocities) velocities = body_velocities(p, r);
  if (velocities) {
    if (!stored.global) throw FileError(path, "/solution/v", "a local problem has no velocities");
    check("v", *velocities, without_equality_rows(p).num_dofs());
  }
  const bool frictionless = p.dim == 1;
  AtomicFile target(path);
  target.copy_earlier();
  Hdf5File file(target.draft(), Hdf5File::Mode::kAppend);
  if (file.exists("/solution")) file.remove("/solution");
  if (velocities) {
    file.write("/solution/v", span(stored_velocities(p, *velocities)));
  }
  if (p.equality) file.write("/solution/l", span(multipliers(p, r)));
  file.write("/solution/u", span(frictionless ? spread(u) : u));
  file.write("/solution/r", span(frictionless ? spread(r) : r));
  file.close();
  target.commit();
}

}  // namespace bipot
