// What it costs to ask where an image was taken, and to add one. One thread. Run:
// eifmap_bench_place.
// Not a test: no figure can fail it. Wanted: 2 ms of CPU for a query among 1,000, 10 among 5,000.
#include <benchmark/benchmark.h>

#include "place/place_index.h"
#include "place/random_frame.h"

namespace eifmap {
namespace {

constexpr int kFeatures = 1000;

PlaceIndex index_of(int images) {
  PlaceIndex index;
  for (int i = 0; i < images; ++i)
    index.add(i, test::random_frame(static_cast<std::uint64_t>(i), kFeatures));
  return index;
}

void query(benchmark::State& state) {
  const PlaceIndex index = index_of(static_cast<int>(state.range(0)));
  const FeatureFrame frame = test::random_frame(3, kFeatures);
  for (auto _ : state) benchmark::DoNotOptimize(index.query(frame, 5));
}
BENCHMARK(query)->Arg(1000)->Arg(5000)->Unit(benchmark::kMillisecond);

// As a keyframe's job does: to a copy of what others are reading.
void add_to_copy(benchmark::State& state) {
  const PlaceIndex index = index_of(static_cast<int>(state.range(0)));
  const FeatureFrame frame = test::random_frame(3, kFeatures);
  for (auto _ : state) {
    PlaceIndex copy = index;
    copy.add(1'000'000, frame);
    benchmark::DoNotOptimize(copy);
  }
}
BENCHMARK(add_to_copy)->Arg(1000)->Arg(5000)->Unit(benchmark::kMillisecond);

// Once a map: its words.
void learn(benchmark::State& state) {
  std::vector<FeatureFrame> frames;
  for (int i = 0; i < PlaceOptions().learn_from; ++i)
    frames.push_back(test::random_frame(static_cast<std::uint64_t>(i), kFeatures));
  for (auto _ : state) {
    PlaceIndex index;
    for (std::size_t i = 0; i < frames.size(); ++i) index.add(static_cast<int>(i), frames[i]);
    benchmark::DoNotOptimize(index);
  }
}
BENCHMARK(learn)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace eifmap

BENCHMARK_MAIN();
