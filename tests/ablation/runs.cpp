#include "ablation/runs.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "ablation/workers.h"

namespace eifmap::test {
namespace {

// Rows share the features of the same options and rate, and the runs of the same configuration.
struct Plan {
  struct Features {
    FeatureOptions options;
    int every = 1;
  };
  struct Setting {
    MapperOptions mapper;
    size_t features = 0;

    bool is_slow() const {
      return mapper.relative_pose.covariance == RelativePoseCovariance::kUnscented;
    }
  };
  std::vector<Features> features;
  std::vector<Setting> settings;
  std::vector<size_t> setting_of_row;
};

// Where the key's thing is in `things`, which has it from now on.
template <class Thing>
size_t index_of(std::map<std::string, size_t>& known, const std::string& key,
                std::vector<Thing>& things, const Thing& thing) {
  const auto [entry, is_new] = known.emplace(key, things.size());
  if (is_new) things.push_back(thing);
  return entry->second;
}

Plan plan_of(std::span<const Row> rows) {
  Plan plan;
  std::map<std::string, size_t> known_features, known_settings;
  for (const Row& row : rows) {
    const ServerConfig config = config_of(row);
    ServerConfig features_only;
    features_only.features = config.features;
    const std::string rate = ' ' + std::to_string(row.every);
    const size_t features = index_of(known_features, config_text(features_only) + rate,
                                     plan.features, {config.features, row.every});
    plan.setting_of_row.push_back(index_of(known_settings, config_text(config) + rate,
                                           plan.settings, {config.mapper, features}));
  }
  return plan;
}

std::vector<FeatureSet> extract_all(const Recording& recording, const Plan& plan, int workers) {
  std::vector<cv::Mat> images(recording.size());
  in_workers(workers, images.size(),
             [&](size_t i) { images[i] = recording.image(static_cast<int>(i)); });
  std::vector<FeatureSet> sets(plan.features.size());
  in_workers(workers, sets.size(), [&](size_t i) {
    const Plan::Features& features = plan.features[i];
    sets[i] = extract_features(recording, images, features.options, features.every);
  });
  return sets;
}

int seeds_of(const Plan::Setting& setting, const RunOptions& options) {
  return setting.is_slow() ? std::min(options.seeds, options.slow_seeds) : options.seeds;
}

// One run: of a setting, with a seed's noise.
struct Run {
  size_t setting = 0;
  int seed = 1;
};

// The slow ones first: no thread is left alone with one at the end.
std::vector<Run> runs_of(const Plan& plan, const RunOptions& options) {
  std::vector<Run> runs;
  for (size_t setting = 0; setting < plan.settings.size(); ++setting)
    for (int seed = 1; seed <= seeds_of(plan.settings[setting], options); ++seed)
      runs.push_back({setting, seed});
  std::ranges::stable_partition(
      runs, [&plan](const Run& run) { return plan.settings[run.setting].is_slow(); });
  return runs;
}

int frames_at(const Recording& recording, int every) {
  return (recording.size() + every - 1) / every;
}

double extraction_ms(ExtractorKind kind) {
  switch (kind) {
    case ExtractorKind::kSurfUpright:
      return 15;
    case ExtractorKind::kSurfOriented:
      return 20;
    case ExtractorKind::kAuto:
      return 20;
    case ExtractorKind::kSift:
      return 120;
  }
  return 0;
}

}  // namespace

Outcomes run_rows(const Recording& recording, std::span<const Row> rows, const RunOptions& options,
                  const Say& say) {
  const Plan plan = plan_of(rows);
  say("features, " + std::to_string(plan.features.size()) + " times");
  const std::vector<FeatureSet> features = extract_all(recording, plan, options.workers);

  const std::vector<Run> runs = runs_of(plan, options);
  Outcomes outcomes;
  for (const Plan::Setting& setting : plan.settings)
    outcomes.emplace_back(seeds_of(setting, options));
  size_t done = 0;
  std::mutex saying;
  in_workers(options.workers, runs.size(), [&](size_t i) {
    const Run& run = runs[i];
    const Plan::Setting& setting = plan.settings[run.setting];
    outcomes[run.setting][run.seed - 1] =
        run_once(recording, features[setting.features], setting.mapper, run.seed);
    const std::scoped_lock lock(saying);
    say(std::to_string(++done) + " of " + std::to_string(runs.size()) + " runs");
  });

  Outcomes of_rows;
  for (const size_t setting : plan.setting_of_row) of_rows.push_back(outcomes[setting]);
  return of_rows;
}

double estimated_cpu_s(const Recording& recording, std::span<const Row> rows,
                       const RunOptions& options) {
  constexpr double kMapperMs = 10, kSlowMapperMs = 110;
  const Plan plan = plan_of(rows);
  double ms = 0;
  for (const Plan::Features& features : plan.features)
    ms += extraction_ms(features.options.extractor) * frames_at(recording, features.every);
  for (const Plan::Setting& setting : plan.settings)
    ms += (setting.is_slow() ? kSlowMapperMs : kMapperMs) * seeds_of(setting, options) *
          frames_at(recording, plan.features[setting.features].every);
  return 1e-3 * ms;
}

}  // namespace eifmap::test
