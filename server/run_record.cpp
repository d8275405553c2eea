#include "server/run_record.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <unordered_set>

#include "names.h"
#include "sequence/decisions_file.h"
#include "sequence/measurements_file.h"
#include "sequence/ply.h"
#include "sequence/tum.h"

namespace eifmap {
namespace {

using Json = nlohmann::ordered_json;

Json reasons_json(const std::map<Reason, std::int64_t>& counts) {
  Json json = Json::object();
  for (const auto& [reason, count] : counts)
    if (reason != Reason::kNone) json[describe(reason).name] = count;
  return json;
}

Json sources_json(const std::map<PoseSource, std::int64_t>& counts) {
  Json json = Json::object();
  for (const auto& [source, count] : counts) json[std::string(name(source))] = count;
  return json;
}

Json nis_json(const MapperStatistics& statistics) {
  Json json = Json::object();
  for (const auto& [kind, nis] : statistics.nis)
    if (nis.count > 0)
      json[std::string(name(kind))] = {
          {"ratio", nis.ratio}, {"sigma", nis.sigma}, {"count", nis.count}, {"beyond", nis.beyond}};
  json["suspect"] = statistics.sigma_suspect;
  return json;
}

Json loops_json(const LoopCounts& loops) {
  return {{"closed", loops.closed},
          {"joined", loops.joined},
          {"refused", reasons_json(loops.refused)},
          {"last", loops.last}};
}

Json submaps_json(const SubmapCounts& submaps) {
  return {{"kept", submaps.kept},
          {"returned", submaps.returned},
          {"merged", submaps.merged},
          {"refused", reasons_json(submaps.refused)},
          {"last", submaps.last}};
}

Json steps_json(const StepTimer& timer) {
  Json json = Json::object();
  for (const auto& [step, time] : timer.summary())
    json[step] = {{"frames", time.frames},
                  {"median_ms", time.median_ms},
                  {"p99_ms", time.p99_ms},
                  {"total_s", time.total_s}};
  return json;
}

Json measurements_json(const MapperStatistics& statistics) {
  const bool fixed = statistics.scale.status == ScaleStatus::kFixed;
  Json json = {{"scale", fixed ? "fixed" : "free"}};
  if (fixed) json["metres_per_unit"] = statistics.scale.metres_per_unit;
  if (fixed && std::isfinite(statistics.scale.sigma)) json["scale_sigma"] = statistics.scale.sigma;
  if (fixed && std::isfinite(statistics.scale.sigma_newest))
    json["scale_sigma_newest"] = statistics.scale.sigma_newest;
  for (const auto& [kind, count] : statistics.measurements.kinds)
    json[std::string(name(kind))] = {
        {"used", count.used}, {"refused", count.refused}, {"dropped", count.dropped}};
  json["earth"] = name(statistics.earth.status);
  if (statistics.earth.status != EarthStatus::kUnknown) {
    const auto& [q, t] = statistics.earth.earth_from_map;
    json["earth_from_map"] = {{"position", {t.x(), t.y(), t.z()}},
                              {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
  }
  json["waiting"] = statistics.measurements_waiting;
  json["refusals"] = reasons_json(statistics.measurements.refusals);
  return json;
}

std::string write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  return out ? "" : file.string() + ": cannot be written";
}

template <class Entry>
std::string lines_of(const std::vector<Entry>& entries) {
  std::string lines;
  for (const Entry& entry : entries) lines += line_of(entry) + "\n";
  return lines;
}

// None are there: nor those of a run before.
std::string write_or_remove(const std::filesystem::path& file,
                            const std::vector<AbsoluteMeasurement>& measurements) {
  std::error_code error;
  if (!measurements.empty()) return write_text(file, lines_of(measurements));
  std::filesystem::remove(file, error);
  return error ? file.string() + ": cannot be removed" : "";
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

rusage usage() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

}  // namespace

std::string output_problem(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && access(folder.c_str(), W_OK | X_OK) != 0) error = {errno, std::generic_category()};
  if (!error && std::filesystem::is_directory(folder, error)) return "";
  return folder.string() + ": nothing can be written there (" +
         (error ? error.message() : std::string("it is a file")) +
         "); give another folder by --output";
}

double process_cpu_seconds() {
  const rusage now = usage();
  return seconds(now.ru_utime) + seconds(now.ru_stime);
}

double peak_rss_mib() {
  return static_cast<double>(usage().ru_maxrss) / 1024;
}

// A map that was there before has frames of before.
std::int64_t RunRecord::num_of_this_run(const std::vector<TimedPose>& trajectory) const {
  std::unordered_set<std::int64_t> times;
  for (const Decision& decision : decisions_) times.insert(decision.time_us);
  return std::count_if(trajectory.begin(), trajectory.end(),
                       [&times](const TimedPose& p) { return times.contains(p.time_us); });
}

void RunRecord::add(const FrameResult& result) {
  ++frames_;
  if (!result.rejected) decisions_.push_back(decision_of(result));
  if (result.rejected) ++rejected_[result.reason];
  path_.add(result);
}

std::string RunRecord::write(const std::filesystem::path& folder, const Mapper& mapper,
                             const StepTimer& timer, const std::string& source) const {
  if (std::string problem = output_problem(folder); !problem.empty()) return problem;

  const std::vector<TimedPose> final_trajectory = mapper.final_trajectory();
  const MapperStatistics& statistics = mapper.statistics();
  PublishedPath path = path_;
  path.note_scale(path.last_map_id(), statistics.scale);  // known after the last frame, maybe
  std::int64_t rejected = 0;
  for (const auto& [reason, count] : rejected_) rejected += count;
  const auto per_frame = [this](double x) { return frames_ > 0 ? x / frames_ : 0.0; };

  Json report;
  report["source"] = source;
  report["frames"] = frames_;
  report["tracked"] = path_.size();
  report["coverage"] = per_frame(static_cast<double>(num_of_this_run(final_trajectory)));
  report["keyframes"] = statistics.keyframes;
  report["sigma_factor"] = statistics.sigma_factor;
  report["landmarks"] = statistics.landmarks;
  report["observations"] = statistics.observations;
  report["edges"] = statistics.edges;
  report["starts"] = statistics.starts;
  report["losses"] = statistics.losses;
  report["moving_matches"] = {{"total", statistics.moving_matches},
                              {"most", statistics.most_moving},
                              {"frames", statistics.frames_with_moving}};
  report["bound"] = {{"removed_keyframes", statistics.removed_keyframes},
                     {"removed_landmarks", statistics.removed_landmarks}};
  report["loops"] = loops_json(statistics.loops);
  report["submaps"] = submaps_json(statistics.submaps);
  report["nis"] = nis_json(statistics);
  if (!statistics.measurements.kinds.empty() || statistics.measurements_waiting > 0)
    report["measurements"] = measurements_json(statistics);
  report["rejected"] = rejected;
  report["rolls_unseen"] = rolls_unseen_;
  report["pose_sources"] = sources_json(statistics.sources);
  report["reasons"] = reasons_json(statistics.reasons);
  report["rejected_reasons"] = reasons_json(rejected_);
  report["cpu_s"] = process_cpu_seconds();
  report["cpu_ms_per_frame"] = 1000 * per_frame(process_cpu_seconds());
  const std::map<std::string, StepTime> steps = timer.summary();
  const auto whole = steps.find("frame");
  report["wall_s"] = whole == steps.end() ? 0.0 : whole->second.total_s;
  report["peak_rss_mib"] = peak_rss_mib();
  report["steps"] = steps_json(timer);

  for (const std::string& problem :
       {write_tum(folder / "trajectory.tum", path.poses()),
        write_tum(folder / "trajectory_final.tum", final_trajectory),
        write_tum(folder / "keyframes.tum", mapper.keyframe_trajectory()),
        write_ply(folder / "map.ply", mapper.map_points()),
        write_text(folder / "decisions.jsonl", lines_of(decisions_)),
        write_or_remove(folder / "measurements.jsonl", measurements_),
        write_text(folder / "report.json", report.dump(1) + "\n")})
    if (!problem.empty()) return problem;
  return "";
}

}  // namespace eifmap
