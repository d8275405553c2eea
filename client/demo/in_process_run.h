// Server, publisher and logger in one process, on one LCM object of its own: the whole line without
// a network to set up.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "client/image_source.h"
#include "client/publisher.h"
#include "client/view/view_feed.h"
#include "map_view.h"

namespace eifmap {

struct InProcessOptions {
  std::filesystem::path output;  // the server's files; the logger's in its folder log/
  PublishAs as = PublishAs::kRaw;
  View* view = nullptr;  // filled too, where there is one
};

struct InProcessResult {
  std::string problem;           // "" or what went wrong
  int published = 0;             // images
  std::int64_t poses = 0;        // images answered with a pose message
  std::int64_t tracked = 0;      // of them with a pose
  std::vector<MapPoint> points;  // the map as it arrived by message
  std::string last_words;        // the server's last reason and hint, "" when all is well
};

// Called now and then with the number of images that the server is done with; false stops the run.
using InProcessProgress = std::function<bool(int done)>;

// Lossless: the publisher keeps only a few images ahead of the mapper.
InProcessResult run_in_process(ImageSource& source, const InProcessOptions& options,
                               const InProcessProgress& progress);

}  // namespace eifmap
