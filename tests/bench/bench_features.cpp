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

void extract(benchmark::State& state, ExtractorKind kind, int step) {
  Camera camera;
  camera.width = static_cast<int>(state.range(0));
  camera.height = static_cast<int>(state.range(1));
  camera.fx = camera.fy = camera.width;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  const cv::Mat image = textured(camera.width, camera.height);
  FeatureOptions options;
  options.extractor = kind;
  options.surf.sampling_step = step;
  FeatureExtractor extractor(options);
  std::size_t features = 0;
  for (auto _ : state) features = extractor.extract(image, camera).keypoints.size();
  state.counters["features"] = static_cast<double>(features);
}
void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"width", "height"})->Args({640, 480})->Args({1241, 376});
  benchmark->Unit(benchmark::kMillisecond);
}
BENCHMARK_CAPTURE(extract, surf_upright, ExtractorKind::kSurfUpright, 1)->Apply(sizes);
BENCHMARK_CAPTURE(extract, surf_upright_step_2, ExtractorKind::kSurfUpright, 2)->Apply(sizes);
BENCHMARK_CAPTURE(extract, surf_oriented, ExtractorKind::kSurfOriented, 1)->Apply(sizes);
BENCHMARK_CAPTURE(extract, sift, ExtractorKind::kSift, 1)->Apply(sizes);
BENCHMARK_CAPTURE(extract, level, ExtractorKind::kAuto, 1)->Apply(sizes);

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
