#include "decision.h"

#include <bit>

namespace eifmap {
namespace {

// FNV-1a over 64-bit words (G. Fowler, L. Noll, P. Vo).
class Digest {
 public:
  void add(std::int64_t value) {
    for (int byte = 0; byte < 8; ++byte)
      hash_ = (hash_ ^ ((static_cast<std::uint64_t>(value) >> (8 * byte)) & 0xff)) * 1099511628211u;
  }
  void add(double value) { add(std::bit_cast<std::int64_t>(value)); }
  std::int64_t value() const { return static_cast<std::int64_t>(hash_); }

 private:
  std::uint64_t hash_ = 14695981039346656037u;
};

}  // namespace

// Not of the map's number, which counts what the server mapped before.
Decision decision_of(const FrameResult& result) {
  Digest digest;
  digest.add(static_cast<std::int64_t>(result.state));
  digest.add(static_cast<std::int64_t>(result.source));
  digest.add(static_cast<std::int64_t>(result.reason));
  digest.add(std::int64_t{result.num_inliers});
  for (const double x : result.map_from_camera.rotation.coeffs()) digest.add(x);
  for (const double x : result.map_from_camera.translation) digest.add(x);
  return {result.time_us, result.publisher,    result.seq,        result.adopted_job,
          digest.value(), result.measurements, result.after_reset};
}

}  // namespace eifmap
