#include "palpate/physics/deformable/sparse_solver.h"

#include <dmumps_c.h>

#include <algorithm>
#include <mutex>
#include <utility>

namespace palpate::physics::deformable {
namespace {

constexpr int kBegin = -1, kEnd = -2, kAnalyse = 1, kFactorise = 2, kSolve = 3;  // MUMPS' JOB
constexpr int kSequential = -987654;       // its communicator of a single process
constexpr int kPord = 4;                   // ICNTL(7), the ordering; Scotch's is another in each run
constexpr int kColumnsInOneSolve = 32;     // ICNTL(27)
constexpr int kWholeByColumns = 3;         // ICNTL(19), Schur's complement
constexpr int kCondense = 1, kExpand = 2;  // ICNTL(26)

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
  std::vector<MUMPS_INT> kept;  // 1-based
  std::vector<double> right;    // of the solution that is condensed
  Eigen::MatrixXd condensed;
  bool begun = false, factorised = false, is_condensed = false;

  void keep(const std::vector<int>& equations) {
    for (const int equation : equations) kept.push_back(equation + 1);
    const auto count = static_cast<MUMPS_INT>(kept.size());
    condensed.resize(count, count);
    mumps.icntl[18] = kWholeByColumns;
    mumps.size_schur = count;
    mumps.listvar_schur = kept.data();
    mumps.schur = condensed.data();
    mumps.schur_lld = mumps.schur_mloc = mumps.schur_nloc = count;
    mumps.nprow = mumps.npcol = 1;
    mumps.mblock = mumps.nblock = count;
  }

  // The library keeps things in variables of its own: whoever calls it, for whichever factor, waits for the others.
  void call(int job) {
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
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

Expected<SparseFactor> SparseFactor::analyse(const SymmetricMatrix& matrix, const std::vector<int>& kept) {
  for (const auto* numbers : {&matrix.rows, &kept})
    for (const int row : *numbers)
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
  mumps.icntl[6] = kPord;
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
  if (!kept.empty()) library->keep(kept);
  library->call(kAnalyse);
  if (auto good = answer_of(mumps, "order"); !good) return tl::unexpected(good.error());
  return SparseFactor(std::move(library));
}

Expected<void> SparseFactor::factorise(const SymmetricMatrix& matrix) {
  auto& mumps = library_->mumps;
  library_->factorised = library_->is_condensed = false;
  library_->values = matrix.values;
  mumps.a = library_->values.data();
  library_->call(kFactorise);
  if (auto good = answer_of(mumps, "factorise"); !good) return good;
  if (mumps.infog[11] > 0)
    return refused("sparse solver: the matrix is not positive definite, {} pivots are negative",
                   mumps.infog[11]);
  library_->factorised = true;
  if (!library_->kept.empty()) {
    // The library promises one triangle of a symmetric one. In its place, which the library knows.
    auto& whole = library_->condensed;
    for (Eigen::Index column = 1; column < whole.cols(); ++column)
      whole.col(column).head(column) = whole.row(column).head(column).transpose();
  }
  return {};
}

Expected<void> SparseFactor::solve(Eigen::MatrixXd& columns) const {
  if (!library_->factorised || !library_->kept.empty())
    return refused("sparse solver: nothing is factorised whole");
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

Eigen::MatrixXd SparseFactor::condensed() const {
  return library_->factorised ? library_->condensed : Eigen::MatrixXd();
}

Expected<Eigen::VectorXd> SparseFactor::condense(const Eigen::VectorXd& right) const {
  if (!library_->factorised || library_->kept.empty() || right.size() != library_->mumps.n)
    return refused("sparse solver: nothing is factorised that keeps equations, for {} values", right.size());
  auto& mumps = library_->mumps;
  Eigen::VectorXd left(mumps.size_schur);
  library_->right.assign(right.begin(), right.end());
  mumps.rhs = library_->right.data();
  mumps.nrhs = 1;
  mumps.lrhs = mumps.n;
  mumps.redrhs = left.data();
  mumps.lredrhs = mumps.size_schur;
  mumps.icntl[25] = kCondense;
  library_->call(kSolve);
  if (auto good = answer_of(mumps, "condense"); !good) return tl::unexpected(good.error());
  library_->is_condensed = true;
  return left;
}

Expected<Eigen::VectorXd> SparseFactor::expand(const Eigen::VectorXd& kept) const {
  auto& mumps = library_->mumps;
  if (!library_->is_condensed || kept.size() != mumps.size_schur)
    return refused("sparse solver: nothing is condensed, for {} values", kept.size());
  Eigen::VectorXd values = kept;
  mumps.redrhs = values.data();
  mumps.icntl[25] = kExpand;
  library_->call(kSolve);
  if (auto good = answer_of(mumps, "expand"); !good) return tl::unexpected(good.error());
  return Eigen::VectorXd::Map(library_->right.data(), mumps.n);
}

std::int64_t SparseFactor::entries() const {
  const int count = library_->mumps.infog[8];  // in millions where it is negative
  return count >= 0 ? count : -1000000LL * count;
}

}  // namespace palpate::physics::deformable
