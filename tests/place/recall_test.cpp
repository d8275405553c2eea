// How often the index knows where a rendered image was taken.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "features/front_end.h"
#include "place/place_index.h"
#include "simulation/simulated_world.h"

namespace eifmap {
namespace {

// Of a world, every `step`th image from `first` on.
std::vector<std::pair<int, FeatureFrame>> images(const SimulatedWorld& world, int first, int last,
                                                 int step) {
  FeatureExtractor extractor;
  std::vector<std::pair<int, FeatureFrame>> frames;
  for (int i = first; i < last; i += step)
    frames.emplace_back(i, extract_frame(extractor, world.render(i), world.camera(), {}));
  return frames;
}

struct Recall {
  int asked = 0, first = 0, among_5 = 0;
  double share_first() const { return static_cast<double>(first) / asked; }
  double share_among_5() const { return static_cast<double>(among_5) / asked; }
};

Recall recall_of(const PlaceIndex& index, const std::vector<std::pair<int, FeatureFrame>>& asked,
                 int near) {
  Recall recall;
  for (const auto& [i, frame] : asked) {
    ++recall.asked;
    const auto places = index.query(frame, 5);
    const auto is_right = [&](const PlaceScore& place) { return std::abs(place.id - i) <= near; };
    recall.first += !places.empty() && is_right(places.front());
    recall.among_5 += std::any_of(places.begin(), places.end(), is_right);
  }
  return recall;
}

// Every 12th image is known, those in between are asked for. Measured: 1 and 1.
TEST(PlaceRecall, OfACourtyard) {
  const SimulatedWorld world;
  PlaceIndex index;
  for (const auto& [i, frame] : images(world, 0, 360, 12)) index.add(i, frame);
  const Recall recall = recall_of(index, images(world, 6, 348, 12), 6);
  RecordProperty("first", std::to_string(recall.share_first()));
  RecordProperty("among_5", std::to_string(recall.share_among_5()));
  EXPECT_GE(recall.share_first(), 0.9);
  EXPECT_GE(recall.share_among_5(), 0.97);
}

}  // namespace
}  // namespace eifmap
