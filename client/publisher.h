// Publishes a source's images as a camera driver would, and the camera's calibration.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absolute_measurement.h"
#include "bus/bus.h"
#include "client/image_source.h"
#include "features/extractor.h"

namespace eifmap {

enum class PublishAs {
  kRaw,       // gray pixels
  kMjpeg,     // the recorded JPEG as it is, else compressed here
  kFeatures,  // extracted here: the server never sees pixels
};

struct PublishOptions {
  std::string camera = "camera";
  PublishAs as = PublishAs::kFeatures;
  int jpeg_quality = 90;
  // Images a second; 0: as fast as it can; < 0: as the time stamps say.
  double rate_hz = -1;
  std::chrono::milliseconds start_delay{0};  // between the first calibration and the first image
  std::int64_t publisher = 0;                // 0: a random one for this start
  // kFeatures: a larger frame leaves in parts of at most so many bytes, at this pace; 0: whole, at
  // once. See Link. (An image can only leave whole.)
  int max_message_bytes = 0;
  int bytes_per_s = 0;
  FeatureOptions features;  // kFeatures: how
  // Absolute measurements, of the images' clock, in the order of use (usable_from_us): each leaves
  // right before the first image that is not before it, named by this publisher and its place here.
  std::vector<AbsoluteMeasurement> measurements;

  std::string problem() const;  // "" or which field is wrong and why
};

struct PublishResult {
  int published = 0;
  std::int64_t publisher = 0;
  std::int64_t messages = 0;      // that carried them
  std::int64_t measurements = 0;  // sent; those after the last image are not
  std::size_t largest_bytes = 0;  // of a message
  double late_s = 0;              // the longest that an image left after its time
  std::string problem;            // "" or why it stopped early
};

// Asked before image i is made, at least every 0.1 s while waiting (then with the same i), and at
// the end with i == the number of images published: false stops.
using KeepPublishing = std::function<bool(int i)>;

// Sends the calibration at the start and every second, and the images in order with seq = their
// index and their own time stamps; those of a live camera at once, whatever the rate. Blocks until
// the last one has left. Throws std::invalid_argument
// with options.problem().
PublishResult publish(ImageSource& source, const PublishOptions& options, Bus& bus,
                      const KeepPublishing& keep_publishing);

}  // namespace eifmap
