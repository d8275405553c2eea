// Features and matching, one thread. Run: eifmap_bench_features. Not a test: no figure can fail it.
#include <benchmark/benchmark.h>

#include "features/extractor.h"
#include "features/images.h"
#include "features/matcher.h"

namespace eifmap {
namespace {

cv::Mat textured(int width, int height) {
  return testing::view(testing::Texture(1), width, height, Eigen::Matrix3d::Identity(), 1.5, 2);
}

void surf(benchmark::State& state) {
  const cv::Mat image =
      textured(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  FeatureOptions options;
  options.surf.sampling_step = static_cast<int>(state.range(2));
  FeatureExtractor extractor(options);
  std::size_t features = 0;
  for (auto _ : state) features = extractor.extract(image, {}).keypoints.size();
  state.counters["features"] = static_cast<double>(features);
}
BENCHMARK(surf)
    ->ArgNames({"width", "height", "step"})
    ->Args({640, 480, 1})
    ->Args({640, 480, 2})
    ->Args({1241, 376, 1})
    ->Args({1241, 376, 2})
    ->Unit(benchmark::kMillisecond);

FeatureGroup random_group(int size, unsigned seed) {
  std::mt19937 random(seed);
  FeatureGroup group;
  for (int i = 0; i < size; ++i) {
    group.index.push_back(i);
    for (int k = 0; k < kDescriptorSize; ++k)
      group.descriptors.push_back(static_cast<std::int8_t>(static_cast<int>(random() % 64) - 32));
  }
  return group;
}

void match_groups(benchmark::State& state) {
  const int size = static_cast<int>(state.range(0));
  const FeatureGroup a = random_group(size, 1), b = random_group(size, 2);
  for (auto _ : state) benchmark::DoNotOptimize(match(a, b, {}));
}
BENCHMARK(match_groups)->Arg(500)->Arg(1000)->Unit(benchmark::kMillisecond);

void distance(benchmark::State& state) {
  const FeatureGroup group = random_group(64, 3);
  for (auto _ : state)
    for (std::size_t i = 0; i < 63; ++i)
      benchmark::DoNotOptimize(descriptor_distance(&group.descriptors[i * kDescriptorSize],
                                                   &group.descriptors[(i + 1) * kDescriptorSize]));
  state.SetItemsProcessed(state.iterations() * 63);
}
BENCHMARK(distance);

}  // namespace
}  // namespace eifmap

BENCHMARK_MAIN();
