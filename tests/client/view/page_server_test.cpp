#include "client/view/page_server.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "client/view/page_copy.h"
#include "client/view/raw_page.h"
#include "client/view/view_messages.h"

namespace eifmap {
namespace {

using test::PageCopy;
using test::RawPage;

std::string file_text(const std::string& name) {
  std::ifstream in(EIFMAP_SOURCE_DIR "/client/view/web/" + name, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

class PageServerTest : public testing::Test {
 protected:
  PageServerTest() : opened_(PageServer::open({"127.0.0.1", 0}, view_)) {
    if (!opened_.server) throw std::runtime_error(opened_.problem);
  }
  PageServer& server() { return *opened_.server; }

  void take_pose(int i) {
    PublishedPose pose;
    pose.origin = {5, "cam"};
    pose.result.map_id = 1;
    pose.result.state = TrackingState::kTracking;
    pose.result.map_from_camera.translation.x() = i;
    view_.model.take(pose, ViewModel::Clock::now());
  }
  // About 2 MB of text.
  void take_large_map(std::int64_t seq) {
    MapUpdate update;
    update.map_id = 1;
    update.base_seq = seq == 1 ? -1 : seq - 1;
    update.seq = seq;
    update.keyframes.push_back({0, 1000, {}});
    for (int i = 0; i < 50000; ++i) {
      LandmarkView landmark;
      landmark.id = i;
      landmark.position_in_anchor = {0.12345 * i, 1.0 / (i + 1), static_cast<double>(seq)};
      landmark.laplacian_sign = 1;
      update.landmarks.push_back(landmark);
    }
    for (const map_part_t& part : publishing_.publish(update, 5))
      view_.model.take(part, ViewModel::Clock::now());
  }
  // Until the path of the page has this many poses.
  static bool follow(RawPage& page, PageCopy& copy, std::size_t poses) {
    while (copy.path.size() < poses) {
      const auto frame = page.next();
      if (!frame) return false;
      if (!frame->binary) copy.apply(frame->bytes);
    }
    return true;
  }

  test::Publishing publishing_;
  View view_;
  PageServer::Opened opened_;
};

TEST_F(PageServerTest, ServesItsFilesAndNothingElse) {
  const std::string page = RawPage(server()).request("GET /");
  EXPECT_TRUE(page.starts_with("HTTP/1.1 200")) << page.substr(0, 100);
  EXPECT_NE(page.find("text/html"), std::string::npos);
  EXPECT_NE(page.find("content-security-policy: default-src 'none'"), std::string::npos);
  EXPECT_EQ(body_of(page), file_text("index.html"));
  EXPECT_EQ(body_of(RawPage(server()).request("GET /view.css")), file_text("view.css"));
  const std::string script = body_of(RawPage(server()).request("GET /view.js"));
  EXPECT_GT(script.size(), 100'000u);
  EXPECT_TRUE(script == file_text("dist/view.js"));
  EXPECT_EQ(body_of(RawPage(server()).request("GET /LICENSES.txt")),
            file_text("dist/LICENSES.txt"));
  EXPECT_TRUE(RawPage(server()).request("GET /../package.json").starts_with("HTTP/1.1 404"));
  EXPECT_TRUE(RawPage(server()).request("GET /none").starts_with("HTTP/1.1 404"));
  EXPECT_TRUE(RawPage(server()).request("DELETE /").starts_with("HTTP/1.1 405"));
}

TEST_F(PageServerTest, ALatePageGetsASnapshotAndThenTheSame) {
  RawPage early(server());
  ASSERT_TRUE(early.upgrade());
  PageCopy early_copy, late_copy;
  for (int i = 0; i < 20; ++i) take_pose(i);
  ASSERT_TRUE(follow(early, early_copy, 20));
  RawPage late(server());
  ASSERT_TRUE(late.upgrade());
  const auto first = late.next();
  ASSERT_TRUE(first);
  EXPECT_NE(first->bytes.find("\"snapshot\":true"), std::string::npos);
  late_copy.apply(first->bytes);
  EXPECT_EQ(late_copy.path.size(), 20u);
  for (int i = 20; i < 40; ++i) take_pose(i);
  ASSERT_TRUE(follow(early, early_copy, 40));
  ASSERT_TRUE(follow(late, late_copy, 40));
  EXPECT_EQ(early_copy, late_copy);
  EXPECT_EQ(server().pages(), 2u);
}

TEST_F(PageServerTest, PicturesComeAsTheyAre) {
  RawPage page(server());
  ASSERT_TRUE(page.upgrade());
  ImageMessage image;
  image.format = PixelFormat::kMjpeg;
  image.data = {0xff, 0xd8, 0, 1, 2, 0xff, 0xd9};
  view_.picture.take(image);
  const auto is_picture = [&](RawPage& at) {
    for (auto frame = at.next(); frame; frame = at.next())
      if (frame->binary) return frame->bytes == std::string(image.data.begin(), image.data.end());
    return false;
  };
  EXPECT_TRUE(is_picture(page));
  RawPage late(server());
  ASSERT_TRUE(late.upgrade());
  EXPECT_TRUE(is_picture(late));
}

TEST_F(PageServerTest, OtherSitesGetNothing) {
  EXPECT_FALSE(RawPage(server()).upgrade("http://elsewhere.example"));
  EXPECT_FALSE(RawPage(server()).upgrade("null"));
  EXPECT_FALSE(RawPage(server()).upgrade("http://" + std::string(250, 'a')));
  EXPECT_EQ(server().pages(), 0u);
}

// It reads nothing while megabytes come for it: the other one has all of it, at once, and it gets a
// snapshot when it reads again.
TEST_F(PageServerTest, ASlowPageHoldsNobodyUp) {
  RawPage slow(server()), quick(server());
  ASSERT_TRUE(slow.upgrade());
  ASSERT_TRUE(quick.upgrade());
  PageCopy slow_copy, quick_copy;
  for (int i = 0; i < 20; ++i) {
    take_large_map(i + 1);
    take_pose(i);
    ASSERT_TRUE(follow(quick, quick_copy, static_cast<std::size_t>(i) + 1)) << "pose " << i;
  }
  EXPECT_EQ(quick_copy.landmarks.size(), 50000u);
  int frames = 0;
  std::size_t bytes = 0;
  while (slow_copy.path.size() < 20) {
    const auto frame = slow.next();
    ASSERT_TRUE(frame) << "it is out of step for good, after " << frames;
    slow_copy.apply(frame->bytes);
    bytes += frame->bytes.size();
    ++frames;
  }
  EXPECT_EQ(slow_copy, quick_copy);
  // It had some of them in its socket, at most 4 MB in the queue, and then a snapshot.
  EXPECT_LT(bytes, 20u << 20) << "what it missed was kept for it: in " << frames << " messages";
}

TEST_F(PageServerTest, PagesComeAndGo) {
  for (int i = 0; i < 10; ++i) {
    take_large_map(i + 1);
    RawPage page(server());
    ASSERT_TRUE(page.upgrade());
    server().service();  // it leaves in the middle of the snapshot
  }
  RawPage last(server());
  ASSERT_TRUE(last.upgrade());
  EXPECT_TRUE(last.next());
  EXPECT_TRUE(last.wait([this] { return server().pages() == 1; }));
}

TEST_F(PageServerTest, ThereIsAnEndToTheNumberOfPages) {
  std::vector<std::unique_ptr<RawPage>> pages;
  for (std::size_t i = 0; i < PageServer::kMaxPages; ++i) {
    pages.push_back(std::make_unique<RawPage>(server()));
    ASSERT_TRUE(pages.back()->upgrade());
  }
  EXPECT_FALSE(RawPage(server()).upgrade());
  pages.clear();
  RawPage next(server());
  EXPECT_TRUE(next.wait([this] { return server().pages() == 0; }));
  EXPECT_TRUE(next.upgrade());
}

}  // namespace
}  // namespace eifmap
