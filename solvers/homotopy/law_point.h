#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/homotopy/law_cells.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

/// A contact problem in equilibrated variables (unit diagonal of W) over the largest velocity, by
/// columns: u = W s + b, the law with friction coefficients mu. A missing W is assembled.
/// W is made symmetric to the last bit if it is so to rounding.
struct LawProblem {
  int dim = 2;
  SparseMatrix W;  ///< m x m
  Vector b;        ///< m
  Vector mu;       ///< c; 0: no friction

  /// s of the contact problem = impulse_unit ∘ s of this one.
  Vector impulse_unit;

  LawProblem(const ContactProblem& problem, const Vector& delassus_diagonal);
  int num_contacts() const { return static_cast<int>(mu.size()); }
  int num_rows() const { return static_cast<int>(b.size()); }
  bool friction(int contact) const { return mu[contact] > 0; }
  /// Tangential part of the impulse of a column with normal part 1.
  double tangent(int contact, Column column) const {
    return column == Column::kPlus ? -mu[contact] : mu[contact];
  }
};

/// A point of the law's manifold: the cells, and the parameter of every column. Contact i owns the
/// slots [i dim, (i + 1) dim), one column each, in any order.
struct LawPoint {
  std::vector<Cell> cell;      ///< c
  std::vector<Column> column;  ///< m
  Vector bound;                ///< m, bound_of() of every slot
  Vector value;                ///< m, the parameters

  /// Puts contact i into a cell, with its columns in the order that gives the matrix of cells a
  /// diagonal without zeros: normal row first.
  void set(const LawProblem& problem, int contact, Cell to);
  /// Sets `bound` from cells and columns, for points stored without it.
  void find_bounds();
  /// Restores the same order of the columns; parameters move with them.
  void sort_columns(int dim);
  void impulse(const LawProblem& problem, Vector& s) const;
  void velocity(const LawProblem& problem, Vector& u) const;
};

/// The point nearest to an impulse with velocity u = W s + b: for each contact the cell that
/// contains the projection of s - u (Alart and Curnier 1991), and its parameters there.
LawPoint nearest_point(const LawProblem& problem, const Vector& s, const Vector& u);

}  // namespace bipot
