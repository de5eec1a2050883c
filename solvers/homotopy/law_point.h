#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/homotopy/law_cells.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

/// A contact problem in equilibrated variables (unit diagonal of W) over the largest velocity, by
/// columns: u = W s + b, the law with the coefficients mu and mu_r. A missing W is assembled.
/// W is made symmetric to the last bit if it is so to rounding.
struct LawProblem {
  int dim = 2;
  SparseMatrix W;  ///< m x m
  Vector b;        ///< m
  Vector mu;       ///< c; 0: no friction
  Vector mu_r;     ///< c, or empty

  /// s of the contact problem = impulse_unit ∘ s of this one.
  Vector impulse_unit;

  LawProblem(const ContactProblem& problem, const Vector& delassus_diagonal);
  int num_contacts() const { return static_cast<int>(mu.size()); }
  int num_rows() const { return static_cast<int>(b.size()); }
  /// The coefficient of the row k of a contact, k > 0.
  double bound(int contact, int k) const { return k == 1 ? mu[contact] : mu_r[contact]; }
  /// Row k > 0 of the impulse of a column with normal part 1.
  double tangent(int contact, Column column, int k = 1) const {
    return (sides(column) >> (k - 1) & 1U) != 0 ? bound(contact, k) : -bound(contact, k);
  }
};

/// A point of the law's manifold: the cells, and the parameter of every column. Contact i owns the
/// slots [i dim, (i + 1) dim), one column each, in any order.
struct LawPoint {
  std::vector<Cell> cell;      ///< c
  std::vector<Column> column;  ///< m
  Vector bound;                ///< m, bound_of() of every slot; not stored with turning points
  Vector value;                ///< m, the parameters

  /// Puts contact i into a cell, with its columns in the order that gives the matrix of cells a
  /// diagonal without zeros: normal row first. With velocity columns as unit vectors, the columns
  /// of every cell are then a positive basis.
  void set(const LawProblem& problem, int contact, Cell to);
  /// Sets `bound` from cells and columns: of all contacts, or of one.
  void find_bounds(const LawProblem& problem);
  void find_bounds(const LawProblem& problem, int contact);
  /// Restores the same order of the columns; parameters move with them.
  void sort_columns(const LawProblem& problem);
  /// Beyond the face where the parameter of `slot` is zero.
  Crossing across(const LawProblem& problem, int slot) const;
  void impulse(const LawProblem& problem, Vector& s) const;
  void velocity(const LawProblem& problem, Vector& u) const;
};

/// The point nearest to an impulse with velocity u = W s + b: for each contact the cell that
/// contains the projection of s - u (Alart and Curnier 1991), and its parameters there.
LawPoint nearest_point(const LawProblem& problem, const Vector& s, const Vector& u);

}  // namespace bipot
