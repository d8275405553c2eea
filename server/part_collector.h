// Feature frames that came in parts, of any camera, made whole in the receiving thread before they
// wait for the mapper.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "convert/feature_parts.h"

namespace eifmap {

class PartCollector {
 public:
  // Frames, encoded, that the part finished. A message that is no good part comes back as it is, so
  // that it is refused and counted where all are.
  std::vector<std::vector<std::uint8_t>> add(const std::string& camera, Bytes message);

  // Of all cameras.
  FeatureAssembler::Counts counts() const;

 private:
  // Of more cameras at a time parts are not kept: who makes up names must not fill the memory.
  static constexpr std::size_t kMaxCameras = 64;

  mutable std::mutex mutex_;
  std::map<std::string, FeatureAssembler> assemblers_;
};

}  // namespace eifmap
