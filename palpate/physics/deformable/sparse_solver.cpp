#include "palpate/physics/deformable/sparse_solver.h"

#include <dmumps_c.h>

#include <algorithm>
#include <utility>

namespace palpate::physics::deformable {
namespace {

constexpr int kBegin = -1, kEnd = -2, kAnalyse = 1, kFactorise = 2, kSolve = 3;  // MUMPS' JOB
constexpr int kSequential = -987654;    // its communicator of a single process
constexpr int kScotch = 3;              // ICNTL(7), the ordering
constexpr int kColumnsInOneSolve = 32;  // ICNTL(27)

Expected<void> answer_of(const DMUMPS_STRUC_C& mumps, const char* what) {
  const int code = mumps.infog[0];
  if (code >= 0) return {};
  if (code == -10 || code == -40)
    return refused("sparse solver: {}: the matrix is not positive definite; is the body held anywhere?",
                   what);
  if (code == -5 || code == -7 || code == -8 || code == -9 || code == -13 || code == -19)
    return refused(ErrorCode::exhausted, "sparse solver: {}: no memory for it ({}, {})", what, code,
                   mumps.infog[1]);
  return refused("sparse solver: {}: MUMPS says {}, {}", what, code, mumps.infog[1]);
}

}  // namespace

int SymmetricMatrix::slot(int row, int column) const {
  const auto begin = rows.begin() + starts[static_cast<std::size_t>(column)];
  const auto end = rows.begin() + starts[static_cast<std::size_t>(column) + 1];
  const auto found = std::lower_bound(begin, end, row);
  return found != end && *found == row ? static_cast<int>(found - rows.begin()) : -1;
}

Eigen::VectorXd SymmetricMatrix::times(const Eigen::VectorXd& x) const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size);
  for (int column = 0; column < size; ++column)
    for (int k = starts[static_cast<std::size_t>(column)]; k < starts[static_cast<std::size_t>(column) + 1];
         ++k) {
      const int row = rows[static_cast<std::size_t>(k)];
      const double value = values[static_cast<std::size_t>(k)];
      y[row] += value * x[column];
      if (row != column) y[column] += value * x[row];
    }
  return y;
}

struct SparseFactor::Library {
  DMUMPS_STRUC_C mumps{};
  std::vector<MUMPS_INT> rows, columns;  // 1-based
  std::vector<double> values;
  bool begun = false, factorised = false;

  void call(int job) {
    mumps.job = job;
    dmumps_c(&mumps);
  }
  ~Library() {
    if (begun) call(kEnd);
  }
};

SparseFactor::SparseFactor(std::unique_ptr<Library> library) : library_(std::move(library)) {}
SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;
SparseFactor& SparseFactor::operator=(SparseFactor&&) noexcept = default;

Expected<SparseFactor> SparseFactor::analyse(const SymmetricMatrix& matrix) {
  for (const int row : matrix.rows)
    if (row < 0 || row >= matrix.size)
      return refused("sparse solver: a row of number {}, and there are {}", row, matrix.size);
  auto library = std::make_unique<Library>();
  auto& mumps = library->mumps;
  mumps.par = 1;
  mumps.sym = 1;
  mumps.comm_fortran = kSequential;
  library->call(kBegin);
  if (auto good = answer_of(mumps, "begin"); !good) return tl::unexpected(good.error());
  library->begun = true;
  for (int k = 0; k < 3; ++k) mumps.icntl[k] = -1;  // no words on the terminal
  mumps.icntl[3] = 0;
  mumps.icntl[6] = kScotch;
  mumps.icntl[13] = 50;  // per cent of memory beyond the estimate
  mumps.icntl[26] = kColumnsInOneSolve;
  for (int column = 0; column < matrix.size; ++column)
    for (int k = matrix.starts[static_cast<std::size_t>(column)];
         k < matrix.starts[static_cast<std::size_t>(column) + 1]; ++k) {
      library->rows.push_back(matrix.rows[static_cast<std::size_t>(k)] + 1);
      library->columns.push_back(column + 1);
    }
  mumps.n = matrix.size;
  mumps.nnz = static_cast<MUMPS_INT8>(library->rows.size());
  mumps.irn = library->rows.data();
  mumps.jcn = library->columns.data();
  library->call(kAnalyse);
  if (auto good = answer_of(mumps, "order"); !good) return tl::unexpected(good.error());
  return SparseFactor(std::move(library));
}

Expected<void> SparseFactor::factorise(const SymmetricMatrix& matrix) {
  auto& mumps = library_->mumps;
  library_->factorised = false;
  library_->values = matrix.values;
  mumps.a = library_->values.data();
  library_->call(kFactorise);
  if (auto good = answer_of(mumps, "factorise"); !good) return good;
  if (mumps.infog[11] > 0)
    return refused("sparse solver: the matrix is not positive definite, {} pivots are negative",
                   mumps.infog[11]);
  library_->factorised = true;
  return {};
}

Expected<void> SparseFactor::solve(Eigen::MatrixXd& columns) const {
  if (!library_->factorised) return refused("sparse solver: nothing is factorised");
  auto& mumps = library_->mumps;
  mumps.rhs = columns.data();
  mumps.nrhs = static_cast<MUMPS_INT>(columns.cols());
  mumps.lrhs = static_cast<MUMPS_INT>(columns.rows());
  library_->call(kSolve);
  return answer_of(mumps, "solve");
}

Expected<void> SparseFactor::solve(Eigen::VectorXd& column) const {
  Eigen::MatrixXd columns = column;
  if (auto good = solve(columns); !good) return good;
  column = columns.col(0);
  return {};
}

std::int64_t SparseFactor::entries() const {
  const int count = library_->mumps.infog[8];  // in millions where it is negative
  return count >= 0 ? count : -1000000LL * count;
}

}  // namespace palpate::physics::deformable
