// What the published map of a recording costs on the wire, a keyframe: bytes of its updates where
// nothing is lost, and the time that putting it all together as a whole takes.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>

#include "convert/map_message.h"
#include "features/front_end.h"
#include "mapper.h"
#include "published/map_part.h"
#include "sequence/recorded_sequence.h"
#include "server/map_publisher.h"

namespace {

using namespace eifmap;

constexpr int kSkipped = 77;

struct Traffic {
  std::vector<double> update_kb;                                // as encoded, in parts
  std::int64_t landmarks = 0, observations = 0, keyframes = 0;  // entries sent
};

void add(const map_part_t& update, Traffic& traffic) {
  std::size_t bytes = 0;
  for (const map_part_t& part : split(update, 32 * 1024)) bytes += encode(part).size();
  traffic.update_kb.push_back(static_cast<double>(bytes) / 1e3);
  traffic.keyframes += update.num_keyframes;
  traffic.landmarks += update.num_landmarks;
  traffic.observations += update.num_observations;
}

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

int run(const std::filesystem::path& folder, double max_median_kb) {
  const RecordedSequence::Opened opened = RecordedSequence::open(folder);
  if (!opened.sequence) {
    std::fprintf(stderr, "%s\n", opened.problem.c_str());
    return 1;
  }
  const RecordedSequence& sequence = *opened.sequence;
  Mapper mapper(sequence.camera(), {});
  FeatureExtractor extractor;
  PublishedMap map;
  Traffic traffic;
  for (int i = 0; i < sequence.size(); ++i) {
    const FrameResult result =
        mapper.process(extract_frame(extractor, sequence.load_gray(i).image, sequence.camera(),
                                     {sequence.time_us(i), 1, i, "cam0"}));
    if (!result.map_updated) continue;
    MapUpdate update = mapper.map_update();
    update.seq = map.seq() + 1;
    if (update.base_seq != -1) update.base_seq = map.seq();
    const map_part_t message = to_message(update, {1, "cam0"}, result.time_us);
    map.apply(message);
    add(message, traffic);
  }
  std::vector<double>& kb = traffic.update_kb;
  if (kb.empty()) {
    std::fprintf(stderr, "no map came of %s\n", folder.c_str());
    return 1;
  }
  std::sort(kb.begin(), kb.end());
  const double median = kb[kb.size() / 2], n = static_cast<double>(kb.size());
  std::printf(
      "%zu updates: median %.1f KB, 90%% %.1f, largest %.1f; on average %.1f keyframes, %.0f "
      "landmarks, "
      "%.0f observations\n",
      kb.size(), median, kb[kb.size() * 9 / 10], kb.back(),
      static_cast<double>(traffic.keyframes) / n, static_cast<double>(traffic.landmarks) / n,
      static_cast<double>(traffic.observations) / n);
  const double begin = cpu_ms();
  std::size_t bytes = 0;
  for (const map_part_t& part : split(map.whole(), 32 * 1024)) bytes += encode(part).size();
  std::printf(
      "the whole map, %zu keyframes, %zu landmarks, %ld observations: %.0f KB, put together in "
      "%.1f ms\n",
      map.keyframes().size(), map.landmarks().size(), static_cast<long>(map.num_observations()),
      static_cast<double>(bytes) / 1e3, cpu_ms() - begin);
  return median <= max_median_kb ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What a published map costs on the wire.");
  std::string folder;
  double max_median_kb = 1e9;
  app.add_option("folder", folder, "a recording")->required();
  app.add_option("--max-median-kb", max_median_kb, "of an update");
  CLI11_PARSE(app, argc, argv);
  if (!std::filesystem::exists(folder)) {
    std::printf("skipped: there is no %s\n", folder.c_str());
    return kSkipped;
  }
  return run(folder, max_median_kb);
}
