#include "sequence/measurements_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <utility>

#include "sequence/text_lines.h"

namespace eifmap {
namespace {

using Json = nlohmann::ordered_json;

// Takes one value after the other out of a line; keeps the first problem.
class LineReader {
 public:
  explicit LineReader(const std::string& line) : json_(Json::parse(line, nullptr, false)) {
    if (!json_.is_object()) complain("is no JSON object");
  }
  bool has(const char* key) const { return json_.is_object() && json_.contains(key); }

  std::string text(const char* key) {
    const Json* value = find(key);
    if (value && !value->is_string()) complain(quoted(key) + " is no text");
    return problem_.empty() ? value->get<std::string>() : "";
  }
  std::int64_t integer(const char* key) {
    const Json* value = find(key);
    if (value && !value->is_number_integer()) complain(quoted(key) + " is no whole number");
    return problem_.empty() ? value->get<std::int64_t>() : 0;
  }
  double number(const char* key) {
    const Json* value = find(key);
    if (value && !value->is_number()) complain(quoted(key) + " is no number");
    return problem_.empty() ? value->get<double>() : 0;
  }
  void numbers(const char* key, std::span<double> into) {
    const Json* value = find(key);
    const auto is_number = [](const Json& x) { return x.is_number(); };
    if (value && (!value->is_array() || value->size() != into.size() ||
                  !std::all_of(value->begin(), value->end(), is_number)))
      complain(quoted(key) + " is no list of " + std::to_string(into.size()) + " numbers");
    if (!problem_.empty()) return;
    for (std::size_t k = 0; k < into.size(); ++k) into[k] = (*value)[k].get<double>();
  }
  // What was never asked for is a mistake: it would be left out without a word.
  const std::string& finish() {
    if (json_.is_object())
      for (const auto& [key, value] : json_.items())
        if (!asked_.contains(key)) complain(quoted(key) + " is not known of this kind");
    return problem_;
  }
  void complain(std::string problem) {
    if (problem_.empty()) problem_ = std::move(problem);
  }
  bool ok() const { return problem_.empty(); }

 private:
  static std::string quoted(const std::string& key) { return '"' + key + '"'; }
  const Json* find(const char* key) {
    asked_.insert(key);
    if (!has(key)) complain(quoted(key) + " is missing");
    return problem_.empty() ? &json_[key] : nullptr;
  }

  Json json_;
  std::set<std::string> asked_;
  std::string problem_;
};

void read_position(LineReader& in, AbsoluteMeasurement& m) {
  in.numbers("position", {m.position.data(), 3});
  if (in.has("lever")) in.numbers("lever", {m.lever.data(), 3});
  if (in.has("covariance")) {
    in.numbers("covariance", {m.covariance.data(), 9});
    return;
  }
  const double sigma = in.number("sigma");
  m.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
}

void read_way(LineReader& in, AbsoluteMeasurement& m) {
  m.until_us = in.integer("utime2");
  m.length = in.number("length");
  m.sigma = in.number("sigma");
  if (in.ok() && m.until_us <= m.time_us) in.complain("\"utime2\" is not after \"utime\"");
}

void read_gravity(LineReader& in, AbsoluteMeasurement& m) {
  in.numbers("down", {m.down.data(), 3});
  m.sigma = in.number("sigma");
}

void read_landmarks(LineReader& in, AbsoluteMeasurement& m) {
  m.map_id = in.integer("map");
  m.landmark = {in.integer("a"), in.integer("b")};
  m.length = in.number("length");
  m.sigma = in.number("sigma");
}

using Read = void (*)(LineReader&, AbsoluteMeasurement&);
constexpr std::pair<MeasurementKind, Read> kReaders[] = {
    {MeasurementKind::kPosition, read_position},   {MeasurementKind::kDistance, read_way},
    {MeasurementKind::kOdometry, read_way},        {MeasurementKind::kGravity, read_gravity},
    {MeasurementKind::kLandmarks, read_landmarks},
};

std::string read_line(const std::string& text, AbsoluteMeasurement& m) {
  LineReader in(text);
  const std::string kind = in.text("kind");
  m.time_us = in.integer("utime");
  const auto* reader = std::find_if(std::begin(kReaders), std::end(kReaders),
                                    [&kind](const auto& r) { return name(r.first) == kind; });
  if (reader != std::end(kReaders)) {
    m.kind = reader->first;
    reader->second(in, m);
  } else {
    in.complain("\"kind\" is " + kind +
                ", wanted position, distance, odometry, gravity or landmarks");
  }
  if (in.has("publisher") || in.has("seq")) {
    m.id.publisher = in.integer("publisher");
    m.id.seq = in.integer("seq");
    if (in.ok() && m.id.seq < 0) in.complain("\"seq\" is below 0");
  }
  if (in.ok() && check_measurement(m) == Reason::kBadMeasurementCovariance)
    in.complain(m.kind == MeasurementKind::kGravity ? "its sigma is not above 0 and at most 1 rad"
                                                    : "its sigma or covariance is not positive");
  if (in.ok() && check_measurement(m) != Reason::kNone)
    in.complain(
        m.kind == MeasurementKind::kLandmarks
            ? "its length is not above 0, or \"map\", \"a\" and \"b\" name no map (from 1) and "
              "two landmarks (from 0)"
            : "its numbers are not finite or its length is not above 0");
  return in.finish();
}

}  // namespace

std::string line_of(const AbsoluteMeasurement& m) {
  Json json{{"kind", name(m.kind)}, {"utime", m.time_us}};
  if (m.kind == MeasurementKind::kPosition) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = m.covariance;
    json["position"] = std::vector<double>(m.position.begin(), m.position.end());
    json["covariance"] = std::vector<double>(rows.data(), rows.data() + 9);
    json["lever"] = std::vector<double>(m.lever.begin(), m.lever.end());
  } else {
    json["sigma"] = m.sigma;
  }
  if (m.kind == MeasurementKind::kGravity)
    json["down"] = std::vector<double>(m.down.begin(), m.down.end());
  if (m.kind == MeasurementKind::kLandmarks) {
    json["map"] = m.map_id;
    json["a"] = m.landmark[0];
    json["b"] = m.landmark[1];
  }
  if (has_two_times(m.kind)) json["utime2"] = m.until_us;
  if (is_length(m.kind)) json["length"] = m.length;
  if (m.id.seq >= 0) {
    json["publisher"] = m.id.publisher;
    json["seq"] = m.id.seq;
  }
  return json.dump();
}

MeasurementsFile read_measurements(const std::filesystem::path& file) {
  MeasurementsFile read;
  std::set<MeasurementId> ids;
  read.problem = for_each_text(file, [&](const std::string& text) {
    AbsoluteMeasurement measurement;
    std::string problem = read_line(text, measurement);
    if (!problem.empty()) return problem;
    if (measurement.id.seq < 0)
      measurement.id.seq = static_cast<std::int64_t>(read.measurements.size());
    if (!ids.insert(measurement.id).second)
      return std::string("its publisher and seq are those of a line before");
    read.measurements.push_back(measurement);
    return std::string();
  });
  if (!read.problem.empty()) return {{}, read.problem};
  if (read.measurements.empty()) return {{}, file.string() + ": has no measurements"};
  std::stable_sort(read.measurements.begin(), read.measurements.end(),
                   [](const AbsoluteMeasurement& a, const AbsoluteMeasurement& b) {
                     return usable_from_us(a) < usable_from_us(b);
                   });
  return read;
}

}  // namespace eifmap
