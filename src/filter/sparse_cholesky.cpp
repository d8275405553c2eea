#include "filter/sparse_cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace eifmap {
namespace {

// CHOLMOD's supernodal module calls BLAS. A threaded OpenBLAS would sum in an order that depends on
// the number of cores, so it is held to one thread, whichever flavour the system has chosen.
void pin_blas_to_one_thread() {
  using SetThreads = void (*)(int);
  if (auto* set = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads")))
    set(1);
}

// And it asks OpenMP for four threads for loops that are over before those are awake: a tenth of
// the mapping's CPU time. OpenMP keeps the limit by thread.
void keep_this_thread_from_forking() {
  using SetLevels = void (*)(int);
  thread_local const bool once = [] {
    if (auto* set = reinterpret_cast<SetLevels>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels")))
      set(0);
    return true;
  }();
  static_cast<void>(once);
}

}  // namespace

void BlockMatrix::set_zero() {
  for (PoseBlock& b : block) b.setZero();
}

PoseBlock& BlockMatrix::at(int b, int a) {
  const auto first = row.begin() + start[a], last = row.begin() + start[a + 1];
  return block[std::lower_bound(first, last, b) - row.begin()];
}

struct SparseCholesky::Cholmod {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  cholmod_sparse* matrix = nullptr;

  Cholmod() {
    pin_blas_to_one_thread();
    cholmod_start(&common);
    common.print = 0;  // a library never prints
    common.quick_return_if_not_posdef = 1;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_AMD;
#if EIFMAP_GPL
    common.supernodal = CHOLMOD_AUTO;
#else
    common.supernodal = CHOLMOD_SIMPLICIAL;
#endif
    common.final_ll = 1;  // LL', which an indefinite matrix does not pass; LDL' it would
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
  ~Cholmod() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }

  // Only the upper triangle of the diagonal blocks is stored.
  void allocate(const BlockMatrix& m) {
    cholmod_free_sparse(&matrix, &common);
    std::size_t entries = 0;
    for (int a = 0; a < m.size; ++a) {
      const std::size_t off_diagonal = m.start[a + 1] - m.start[a] - 1;
      entries += off_diagonal * kPoseDof * kPoseDof + kPoseDof * (kPoseDof + 1) / 2;
    }
    const std::size_t n = static_cast<std::size_t>(m.size) * kPoseDof;
    matrix = cholmod_allocate_sparse(n, n, entries, 1, 1, 1, CHOLMOD_REAL, &common);
  }

  void copy(const BlockMatrix& m) {
    auto* column_start = static_cast<int*>(matrix->p);
    auto* row = static_cast<int*>(matrix->i);
    auto* value = static_cast<double*>(matrix->x);
    int next = 0;
    for (int a = 0; a < m.size; ++a) {
      for (int c = 0; c < kPoseDof; ++c) {
        column_start[a * kPoseDof + c] = next;
        for (int k = m.start[a]; k < m.start[a + 1]; ++k) {
          const int rows = m.row[k] == a ? c + 1 : kPoseDof;
          for (int r = 0; r < rows; ++r) {
            row[next] = m.row[k] * kPoseDof + r;
            value[next++] = m.block[k](r, c);
          }
        }
      }
    }
    column_start[m.size * kPoseDof] = next;
  }

  Eigen::MatrixXd solve(int system, const Eigen::MatrixXd& b);
};

SparseCholesky::SparseCholesky() : cholmod_(std::make_unique<Cholmod>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;
SparseCholesky::SparseCholesky(const SparseCholesky&) : SparseCholesky() {}
SparseCholesky& SparseCholesky::operator=(const SparseCholesky& other) {
  if (this != &other) *this = SparseCholesky();
  return *this;
}

bool SparseCholesky::has_factor() const {
  const cholmod_factor* f = cholmod_->factor;
  return f != nullptr && f->xtype != CHOLMOD_PATTERN && f->minor == f->n;
}

bool SparseCholesky::factor(const BlockMatrix& matrix, bool same_pattern) {
  keep_this_thread_from_forking();
  Cholmod& c = *cholmod_;
  const bool reuse = same_pattern && c.factor != nullptr && c.matrix != nullptr &&
                     c.matrix->ncol == static_cast<std::size_t>(matrix.size) * kPoseDof;
  if (!reuse) c.allocate(matrix);
  if (c.matrix == nullptr) return false;
  c.copy(matrix);
  if (!reuse) {
    cholmod_free_factor(&c.factor, &c.common);
    c.factor = cholmod_analyze(c.matrix, &c.common);
  }
  if (c.factor == nullptr) return false;
  cholmod_factorize(c.matrix, c.factor, &c.common);
  return c.common.status == CHOLMOD_OK && has_factor();
}

Eigen::MatrixXd SparseCholesky::Cholmod::solve(int system, const Eigen::MatrixXd& b) {
  if (factor == nullptr || factor->n != static_cast<std::size_t>(b.rows()))
    throw std::invalid_argument("SparseCholesky: nothing of this size was factored");
  cholmod_dense right{};
  right.nrow = b.rows();
  right.ncol = b.cols();
  right.nzmax = b.size();
  right.d = b.rows();
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* solution = cholmod_solve(system, factor, &right, &common);
  if (solution == nullptr) throw std::runtime_error("SparseCholesky: out of memory");
  Eigen::MatrixXd x(b.rows(), b.cols());
  std::memcpy(x.data(), solution->x, sizeof(double) * x.size());
  cholmod_free_dense(&solution, &common);
  return x;
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& b) const {
  return cholmod_->solve(CHOLMOD_A, b);
}

Eigen::MatrixXd SparseCholesky::whiten(const Eigen::MatrixXd& b) const {
  return cholmod_->solve(CHOLMOD_L, cholmod_->solve(CHOLMOD_P, b));
}

}  // namespace eifmap
