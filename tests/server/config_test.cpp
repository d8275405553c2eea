#include "server/config.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/config_fields.h"

namespace eifmap {
namespace {

// Fits whatever a brace initializer wants, to count how many fields a struct has.
struct Anything {
  template <class T>
  operator T() const;  // never defined: only counted with
};

template <class Struct, std::size_t... I>
constexpr bool takes(std::index_sequence<I...>) {
  return requires {
    Struct{(static_cast<void>(I), Anything{})...};
  };
}

template <class Struct, std::size_t N = 40>
constexpr std::size_t field_count() {
  if constexpr (takes<Struct>(std::make_index_sequence<N>{}))
    return N;
  else
    return field_count<Struct, N - 1>();
}

template <class Struct>
std::size_t visited_count() {
  Struct object;
  std::size_t count = 0;
  visit_fields(object, [&](const char*, auto&) { ++count; });
  return count;
}

template <class Struct>
void expect_visited() {
  EXPECT_EQ(visited_count<Struct>(), field_count<Struct>()) << typeid(Struct).name();
}

template <class... Structs>
void expect_all_visited() {
  (expect_visited<Structs>(), ...);
}

TEST(Config, EveryFieldOfEveryOptionsStructHasAKey) {
  expect_all_visited<Camera, SurfOptions, SiftOptions, RollOptions, FeatureOptions, MatchOptions,
                     RelativePoseOptions, ScaleFitOptions, AbsolutePoseOptions, StartOptions,
                     KeyframeOptions, LandmarkOptions, EdgeOptions, FilterOptions, LostOptions,
                     MapperOptions, ServerConfig>();
}

std::string problem_of(const std::string& json) {
  return parse_config(json).problem;
}

TEST(Config, EmptyIsTheDefaults) {
  EXPECT_EQ(problem_of("{}"), "");
  EXPECT_EQ(config_text(parse_config("{}").config), config_text(ServerConfig{}));
}

TEST(Config, WhatIsPrintedReadsBack) {
  ServerConfig config;
  config.camera = "front";
  config.input = InputMode::kLossless;
  config.calibration = Camera{640, 480, CameraModel::kRadialTangential, 500.1, 501.2,
                              320, 240, {0.1, -0.2, 0.001, 0, 0.3}};
  config.mapper.map_sign = MapSignChoice::kPlus;
  config.mapper.edge.enabled = false;
  config.mapper.scale_fit.max_relative_sigma = 0.1234567890123456789;
  const ParsedConfig parsed = parse_config(config_text(config));
  ASSERT_EQ(parsed.problem, "");
  EXPECT_EQ(parsed.config.input, InputMode::kLossless);
  EXPECT_EQ(parsed.config.calibration->id(), config.calibration->id());
  EXPECT_EQ(parsed.config.mapper.scale_fit.max_relative_sigma,
            config.mapper.scale_fit.max_relative_sigma);
  EXPECT_EQ(config_text(parsed.config), config_text(config));
}

TEST(Config, UnknownKeysAreRefusedByTheirFullName) {
  EXPECT_TRUE(problem_of(R"({"imput": "newest"})").starts_with("imput: unknown"));
  EXPECT_TRUE(problem_of(R"({"mapper": {"edge": {"enabld": true}}})")
                  .starts_with("mapper.edge.enabld: unknown"));
}

// Every scalar in the printed configuration, replaced by a thing of another type, is refused by its
// full name.
void expect_wrong_types_refused(const nlohmann::json& whole, const nlohmann::json::json_pointer& at,
                                const std::string& name) {
  const nlohmann::json& value = whole.at(at);
  if (value.is_object()) {
    for (const auto& [key, child] : value.items())
      expect_wrong_types_refused(whole, at / key, name.empty() ? key : name + '.' + key);
    return;
  }
  nlohmann::json changed = whole;
  changed[at] = nlohmann::json::array({nlohmann::json::object()});
  const std::string problem = problem_of(changed.dump());
  EXPECT_TRUE(problem.starts_with(name + ": must be ")) << name << " gives: " << problem;
}

TEST(Config, WrongTypesAreRefusedByTheirFullName) {
  ServerConfig config;
  config.calibration = Camera{640, 480, CameraModel::kPinhole, 500, 500, 320, 240, {}};
  expect_wrong_types_refused(nlohmann::json::parse(config_text(config)),
                             nlohmann::json::json_pointer(), "");
}

TEST(Config, WholeNumbersMustBeWholeAndFit) {
  EXPECT_NE(problem_of(R"({"max_part_bytes": 32768.5})"), "");
  EXPECT_NE(problem_of(R"({"max_part_bytes": 99999999999})"), "");
  EXPECT_NE(problem_of(R"({"max_part_bytes": 18446744073709551615})"), "");
  EXPECT_NE(problem_of(R"({"max_part_bytes": -99999999999})"), "");
}

TEST(Config, ValuesOutOfRangeAreRefused) {
  for (const char* json :
       {R"({"camera": "a b"})", R"({"image_channel": "CAM"})", R"({"max_part_bytes": 100})",
        R"({"status_period_s": 0})", R"({"map_bytes_per_s": 0})", R"({"input": "fastest"})",
        R"({"calibration": {"width": 640}})", R"({"features": {"surf": {"octaves": -1}}})",
        R"({"features": {"sift": {"edge_threshold": 0}}})", R"({"features": {"max_features": 0}})",
        R"({"features": {"extractor": "orb"}})", R"({"max_cameras": 0})", R"({"max_cameras": 65})",
        R"({"metrics_port": 65536})", R"({"metrics_address": "here"})"})
    EXPECT_NE(problem_of(json), "") << json;
}

void expect_far_too_small_refused(const nlohmann::json& whole,
                                  const nlohmann::json::json_pointer& at) {
  const nlohmann::json& value = whole.at(at);
  if (value.is_object()) {
    for (const auto& [key, child] : value.items()) expect_far_too_small_refused(whole, at / key);
  } else if (value.is_number()) {
    nlohmann::json changed = whole;
    changed[at] = -1000;
    EXPECT_NE(problem_of(changed.dump()), "") << at.to_string();
  }
}

// No setting is a number that may be anything: each is checked somewhere.
TEST(Config, EveryNumberHasALowerBound) {
  const auto whole = nlohmann::json::parse(config_text(ServerConfig{}));
  for (const char* section : {"/features", "/mapper"})
    expect_far_too_small_refused(whole, nlohmann::json::json_pointer(section));
}

TEST(Config, WhatIsNoJsonObjectIsRefused) {
  for (const char* json : {"", "{", "[]", "3", "{\"camera\": \"a\",}"})
    EXPECT_NE(problem_of(json), "") << json;
  EXPECT_EQ(parse_config("{\"hfov_deg\": 1e999}", {}).problem,
            "a number in it is too large for any setting");
}

TEST(Config, NamesTheFieldOnce) {
  const std::string surf = parse_config(R"({"features": {"surf": {"octaves": -1}}})").problem;
  EXPECT_TRUE(surf.starts_with("features.surf.octaves")) << surf;
}

}  // namespace
}  // namespace eifmap
