// Where a publisher's images come from: a recorded folder or the simulated world.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sequence/recorded_sequence.h"
#include "simulation/simulated_world.h"

namespace eifmap {

class ImageSource {
 public:
  virtual ~ImageSource() = default;

  virtual std::string name() const = 0;
  virtual int size() const = 0;
  virtual const Camera& camera() const = 0;
  virtual std::vector<TumPose> ground_truth() const = 0;  // may be empty

  // Of image i in [0, size()).
  virtual std::int64_t time_us(int i) const = 0;
  virtual GrayImage gray(int i) const = 0;
  // The image as a JPEG file, where it is one already.
  virtual std::optional<FileBytes> jpeg(int i) const = 0;
};

std::unique_ptr<ImageSource> make_source(RecordedSequence sequence);
std::unique_ptr<ImageSource> make_source(SimulatedWorld world);

// The first `count` images of a source.
std::unique_ptr<ImageSource> first_images(std::unique_ptr<ImageSource> source, int count);

}  // namespace eifmap
