#include <gtest/gtest.h>

#include <array>
#include <sstream>

#include "program/command_line.h"
#include "program/nearest_name.h"
#include "program/progress_bar.h"

namespace eifmap {
namespace {

TEST(NearestName, IsTheOneWithTheFewestChanges) {
  const std::vector<std::string> names{"enabled", "neighbours", "min_inliers", "min_views"};
  EXPECT_EQ(nearest_name("enabld", names), "enabled");
  EXPECT_EQ(nearest_name("neighbors", names), "neighbours");
  EXPECT_EQ(nearest_name("min_vieuws", names), "min_views");
  EXPECT_EQ(nearest_name("colour", names), "");
  EXPECT_EQ(nearest_name("", names), "");
  EXPECT_EQ(nearest_name("x", {}), "");
  EXPECT_EQ(did_you_mean("enabld", names), "; did you mean enabled?");
  EXPECT_EQ(did_you_mean("colour", names), "");
}

// What the command line leads to: "" or the explanation.
std::string parse(const std::vector<const char*>& arguments) {
  CLI::App app("Test.", "tool");
  app.require_subcommand(1);
  CLI::App* send = app.add_subcommand("send", "");
  app.add_subcommand("receive", "");
  int rate = 0, as = 0;
  std::string file;
  send->add_option("--rate", rate)->check(number_in(1, 50));
  send->add_option("--as", as)
      ->transform(one_of(std::vector<std::pair<std::string, int>>{{"raw", 0}, {"features", 1}}));
  send->add_option("file", file);
  std::vector<const char*> argv{"tool"};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  try {
    app.parse(static_cast<int>(argv.size()), argv.data());
  } catch (const CLI::ParseError& error) {
    return explain(app, error);
  }
  return "";
}

TEST(CommandLine, SaysWhatIsWrongInOneSentence) {
  const auto expect = [](const std::vector<const char*>& arguments, const std::string& wanted) {
    const std::string said = parse(arguments);
    EXPECT_NE(said.find(wanted), std::string::npos) << "got: " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  };
  EXPECT_EQ(parse({"send", "--rate", "5", "--as", "raw", "x"}), "");
  expect({"send", "--rat", "5"}, "'--rat' means nothing to tool send; did you mean --rate?");
  expect({"send", "--rat=5"}, "'--rat' means nothing to tool send; did you mean --rate?");
  expect({"send", "x", "y"}, "'y' means nothing to tool send");
  expect({"snd"}, "'snd' means nothing to tool; did you mean send?");
  expect({"send", "--rate", "51"}, "--rate: '51' is out of range, wanted 1 to 50");
  expect({"send", "--rate", "fast"}, "--rate: 'fast' is out of range, wanted 1 to 50");
  expect({"send", "--as", "pictures"}, "--as: 'pictures' is unknown, wanted raw or features");
  expect({"send", "--rate"}, "--rate");
  expect({}, "tool --help shows what there is");
}

TEST(ProgressBar, ALineEachTenthWhereThereIsNoTerminal) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  for (int i = 0; i <= 40; ++i) bar.show(i, 40);
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 11);
  EXPECT_NE(text.find("100 %  40/40 images"), std::string::npos) << text;
}

TEST(ProgressBar, MoreThanWasAnnouncedIsTheWhole) {
  for (const bool terminal : {false, true}) {
    std::ostringstream out;
    {
      ProgressBar bar(out, terminal);
      for (int i = 0; i <= 15; ++i) bar.show(i, 10);
      bar.show(1000, 10);
    }
    EXPECT_NE(out.str().find("100 %  10/10 images"), std::string::npos) << out.str();
    EXPECT_EQ(out.str().back(), '\n');
  }
}

TEST(ProgressBar, CountsWhereNobodyKnowsTheEnd) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  for (int i = 0; i < 100; ++i) bar.show(i, -1);
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << "once a minute";
  EXPECT_TRUE(text.starts_with("0 images")) << text;
}

}  // namespace
}  // namespace eifmap
