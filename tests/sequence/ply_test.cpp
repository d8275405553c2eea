#include "sequence/ply.h"

#include <gtest/gtest.h>

#include <cstring>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

TEST(Ply, HoldsEveryPointWithItsColour) {
  const TemporaryFolder folder;
  const std::vector<MapPoint> points{{{1, 2, 3}, -1, 5}, {{4, 5, 6}, 1, 7}};
  ASSERT_EQ(write_ply(folder.path() / "a.ply", points), "");
  const std::string text = read_text(folder.path() / "a.ply");
  const std::string end = "end_header\n";
  const auto header = text.find(end);
  ASSERT_NE(header, std::string::npos);
  EXPECT_NE(text.find("element vertex 2\n"), std::string::npos);
  const std::string data = text.substr(header + end.size());
  constexpr std::size_t kSize = 3 * 4 + 3 + 4;
  ASSERT_EQ(data.size(), 2 * kSize);
  float position[3];
  std::int32_t observations;
  std::memcpy(position, data.data() + kSize, sizeof(position));
  std::memcpy(&observations, data.data() + kSize + 15, sizeof(observations));
  EXPECT_EQ(position[0], 4);
  EXPECT_EQ(position[2], 6);
  EXPECT_EQ(observations, 7);
  EXPECT_NE(data.substr(12, 3), data.substr(kSize + 12, 3));  // two signs, two colours
}

TEST(Ply, ColoursByHeightFromBlueToRed) {
  const TemporaryFolder folder;
  const std::vector<MapPoint> points{{{0, 2, 0}, 1, 3}, {{0, -2, 0}, 1, 3}};  // low, high
  ASSERT_EQ(write_ply(folder.path() / "a.ply", points, PlyColour::kHeight), "");
  const std::string text = read_text(folder.path() / "a.ply");
  const auto data = text.substr(text.size() - 2 * 19);
  const auto channel = [&data](int point, int c) {
    return static_cast<std::uint8_t>(data[19 * point + 12 + c]);
  };
  EXPECT_GT(channel(0, 2), channel(0, 0));
  EXPECT_GT(channel(1, 0), channel(1, 2));
}

TEST(Ply, EmptyCloudAndUnwritableFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(write_ply(folder.path() / "a.ply", {}), "");
  EXPECT_NE(write_ply(folder.path() / "no" / "a.ply", {}), "");
}

}  // namespace
}  // namespace eifmap
