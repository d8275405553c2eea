#include "server/calibration_book.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "convert/camera_message.h"
#include "convert/image_message.h"

namespace eifmap {
namespace {

Camera of_size(int width, int height) {
  return camera_of_view(width, height, 60);
}

Taken take(CalibrationBook& book, const Camera& camera, bool is_mapped = true) {
  return book.take("cam0", encode(to_message(NamedCamera{1, "cam0", camera})), is_mapped);
}

class CalibrationBookTest : public ::testing::Test {
 protected:
  std::int64_t id_of_frame(std::int64_t id, const Camera& size) const {
    return book_.of_frame("cam0", id, size.width, size.height).id();
  }

  const Camera first_ = of_size(640, 480), second_ = of_size(320, 240), third_ = of_size(64, 64);
  CalibrationBook book_{std::nullopt, 0};
};

TEST_F(CalibrationBookTest, AFrameBelongsToTheWaitingOneWhereItCanOnlyBelongToThat) {
  EXPECT_EQ(book_.of("cam0"), nullptr);
  EXPECT_THROW(id_of_frame(0, first_), std::out_of_range);
  ASSERT_EQ(take(book_, first_).reason, Reason::kNone);
  ASSERT_EQ(take(book_, second_).reason, Reason::kNone);
  EXPECT_EQ(book_.of("cam0")->id(), first_.id()) << "until a frame belongs to the other";

  EXPECT_EQ(id_of_frame(0, first_), first_.id());
  EXPECT_EQ(id_of_frame(0, second_), second_.id());
  EXPECT_EQ(id_of_frame(0, third_), first_.id());
  EXPECT_EQ(id_of_frame(second_.id(), first_), second_.id()) << "an id says more than a size";
  EXPECT_EQ(id_of_frame(first_.id(), second_), first_.id());
  EXPECT_EQ(id_of_frame(third_.id(), second_), first_.id()) << "of one that is not known";

  book_.change("cam0");
  EXPECT_EQ(book_.of("cam0")->id(), second_.id());
  EXPECT_EQ(book_.waiting("cam0").id(), first_.id()) << "frames of it may still come";
  EXPECT_EQ(id_of_frame(0, first_), first_.id());
}

TEST_F(CalibrationBookTest, WhileNothingIsMappedTheLastOneIsInUse) {
  take(book_, first_, false);
  take(book_, second_, false);
  EXPECT_EQ(book_.of("cam0")->id(), second_.id());
  EXPECT_EQ(book_.waiting("cam0").id(), first_.id());
}

TEST_F(CalibrationBookTest, TheConfigurationsIsTheOnlyOne) {
  CalibrationBook book(first_, 0);
  EXPECT_EQ(take(book, first_).reason, Reason::kNone);
  EXPECT_EQ(take(book, second_).reason, Reason::kCalibrationMismatch);
  EXPECT_EQ(book.of("any")->id(), first_.id());
}

TEST_F(CalibrationBookTest, AGuessYieldsToWhatIsToldAndDoesNotWait) {
  CalibrationBook book(std::nullopt, 60);
  ImageMessage image;
  image.time_us = 1000;
  image.width = image.row_stride = 640;
  image.height = 480;
  image.data.assign(640 * 480, 0);
  const std::vector<std::uint8_t> bytes = encode(to_message(image));
  const Channel channel{"cam0", ChannelKind::kImage};
  EXPECT_FALSE(book_.guess(channel, bytes)) << "nobody said how wide it sees";
  EXPECT_TRUE(book.guess(channel, bytes));
  EXPECT_FALSE(book.guess(channel, bytes)) << "there is one by now";
  EXPECT_TRUE(book.is_guessed("cam0"));
  book.withdraw_guess("cam0");
  EXPECT_EQ(book.of("cam0"), nullptr);

  ASSERT_TRUE(book.guess(channel, bytes));
  const Camera told = camera_of_view(640, 480, 80);
  ASSERT_EQ(take(book, told).reason, Reason::kNone);
  EXPECT_EQ(book.of_frame("cam0", 0, 640, 480).id(), told.id()) << "of the same size as the guess";
  book.change("cam0");
  EXPECT_FALSE(book.is_guessed("cam0"));
  EXPECT_THROW(book.waiting("cam0"), std::out_of_range);
}

}  // namespace
}  // namespace eifmap
