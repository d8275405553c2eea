#include "wire/channel.h"

#include <gtest/gtest.h>

#include <regex>
#include <stdexcept>

namespace eifmap {
namespace {

constexpr ChannelKind kAllKinds[] = {
    ChannelKind::kImage,    ChannelKind::kFeatures,    ChannelKind::kCalibration,
    ChannelKind::kPose,     ChannelKind::kMap,         ChannelKind::kStatus,
    ChannelKind::kDecision, ChannelKind::kMeasurement, ChannelKind::kRelativeRequest,
    ChannelKind::kRelative};

TEST(Channel, WhatIsBuiltParsesBack) {
  for (const char* camera : {"a", "front-left_2", "abcdefghijklmnopqrstuvwx"})
    for (const ChannelKind kind : kAllKinds) {
      const std::string name = channel_name(camera, kind);
      EXPECT_LE(name.size(), 63u) << "LCM carries no more";
      EXPECT_EQ(parse_channel(name), (Channel{camera, kind}));
    }
}

TEST(Channel, OthersAreRefused) {
  for (const char* name :
       {"", "eifmap", "eifmap.", "eifmap..image", "eifmap.cam", "eifmap.cam.", "eifmap.cam.images",
        "eifmap.c.a.image", "eifmap.c\xc3\xa4m.image", "eifmap.c m.image", "EIFMAP.cam.image",
        "eifmap.abcdefghijklmnopqrstuvwxy.image", "xeifmap.cam.image"})
    EXPECT_FALSE(parse_channel(name)) << name;
  EXPECT_THROW(channel_name("", ChannelKind::kImage), std::invalid_argument);
  EXPECT_THROW(channel_name("a.b", ChannelKind::kImage), std::invalid_argument);
  EXPECT_THROW(channel_pattern(".*", ChannelKind::kImage), std::invalid_argument);
}

TEST(Channel, LiteralPatternMatchesItsNameOnly) {
  const std::string name = "a.b*c+(d)[e]{f}|g^h$i?j\\k";
  EXPECT_TRUE(std::regex_match(name, std::regex(literal_pattern(name))));
  EXPECT_FALSE(std::regex_match("CAM1x", std::regex(literal_pattern("CAM1."))));
}

TEST(Channel, PatternMatchesItsOwnOnly) {
  const std::regex any(channel_pattern("", ChannelKind::kImage));
  EXPECT_TRUE(std::regex_match("eifmap.cam_1.image", any));
  EXPECT_FALSE(std::regex_match("eifmap.cam_1.features", any));
  EXPECT_FALSE(std::regex_match("eifmapxcam_1ximage", any)) << "the dots are literal";
  const std::regex one(channel_pattern("cam", ChannelKind::kPose));
  EXPECT_TRUE(std::regex_match("eifmap.cam.pose", one));
  EXPECT_FALSE(std::regex_match("eifmap.cam2.pose", one));
}

}  // namespace
}  // namespace eifmap
