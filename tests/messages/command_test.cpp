// Names of commands, and the signatures and secrets that they come with.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <set>
#include <string_view>

#include "command/command_message.h"
#include "command/secret.h"
#include "messages/samples.h"
#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

std::vector<std::uint8_t> bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

Secret secret(std::string_view text = "sixteen bytes or more") {
  return Secret(bytes_of(text));
}

TEST(Command, EveryCodeHasOneName) {
  std::set<std::string> names;
  for (std::int16_t code = command_t::CMD_PING; code <= command_t::CMD_SHUTDOWN; ++code) {
    const CommandText* text = command_text(code);
    ASSERT_TRUE(text) << code;
    EXPECT_EQ(command_named(text->name), text);
    names.insert(text->name);
  }
  EXPECT_EQ(names.size(), all_commands().size());
  EXPECT_EQ(command_text(command_t::CMD_SHUTDOWN + 1), nullptr);
  EXPECT_EQ(command_named("halt"), nullptr);
  EXPECT_EQ(result_name(reply_t::RESULT_DENIED), "DENIED");
  EXPECT_EQ(result_name(-1), "UNKNOWN");
}

TEST(Command, ArgumentsAreThoseItTakes) {
  const auto problem = [](const char* name, std::vector<diagnostic_t> args) {
    command_t command = samples::command();
    command.args = std::move(args);
    return arguments_problem(command, *command_named(name));
  };
  EXPECT_EQ(problem("pause", {}), "");
  EXPECT_EQ(problem("pause", {samples::named("name", "x")}), "pause takes no name");
  EXPECT_EQ(problem("set-scale", {}), "set-scale wants metres_per_unit");
  EXPECT_EQ(problem("set-scale", {samples::named("metres_per_unit", "2")}), "");
  EXPECT_EQ(problem("save", {}), "");
  EXPECT_EQ(problem("load", {samples::named("name", "")}), "load wants name");
}

// RFC 4231, cases 6 and 7, the ones whose keys are long enough to be secrets.
TEST(Mac, IsHmacSha256) {
  const Secret key(std::vector<std::uint8_t>(131, 0xaa));
  const auto hex = [](const Mac& mac) {
    std::string text;
    for (const std::uint8_t byte : mac)
      text += "0123456789abcdef"[byte >> 4], text += "0123456789abcdef"[byte & 15];
    return text;
  };
  EXPECT_EQ(hex(key.mac(bytes_of("Test Using Larger Than Block-Size Key - Hash Key First"))),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
  EXPECT_EQ(hex(key.mac(bytes_of("This is a test using a larger than block-size key and a larger "
                                 "than block-size data. The key needs to be hashed before being "
                                 "used by the HMAC algorithm."))),
            "9b09ffa71b942fcb27635fbcd5b0e944bfdc63644f0713938a7f51535c3a35e2");
}

TEST(Mac, IsOfTheMessageWithoutIt) {
  command_t command = samples::command();
  sign(command, secret());
  command_t without = command;
  without.mac.clear();
  without.mac_size = 0;
  const Mac mac = secret().mac(encode(without));
  EXPECT_TRUE(std::equal(mac.begin(), mac.end(), command.mac.begin(), command.mac.end()));
  EXPECT_TRUE(is_signed_by(command, secret()));
  sign(command, secret());
  EXPECT_TRUE(is_signed_by(command, secret())) << "signed twice is signed";
}

TEST(Mac, AnotherSecretOrNoneIsNone) {
  command_t command = samples::command();
  EXPECT_FALSE(is_signed_by(command, secret()));
  sign(command, secret());
  EXPECT_FALSE(is_signed_by(command, secret("sixteen bytes or morE")));
  command.mac.clear();
  command.mac_size = 0;
  EXPECT_FALSE(is_signed_by(command, secret()));
}

// Whatever of it is changed on the way.
template <class Message>
void expect_no_bit_may_flip(Message message, Decoded<Message> (*decode)(Bytes)) {
  sign(message, secret());
  const std::vector<std::uint8_t> wire = encode(message);
  int taken = 0;
  for (std::size_t at = 0; at < wire.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::uint8_t> bytes = wire;
      bytes[at] ^= static_cast<std::uint8_t>(1 << bit);
      const Decoded<Message> decoded = decode(bytes);
      if (!decoded.ok()) continue;
      ++taken;
      EXPECT_FALSE(is_signed_by(decoded.value, secret())) << "bit " << bit << " of byte " << at;
    }
  EXPECT_GT(taken, 400) << "else this shows little";
}

TEST(Mac, NoBitMayFlip) {
  expect_no_bit_may_flip(samples::command(), &decode_command);
  expect_no_bit_may_flip(samples::reply(), &decode_reply);
}

TEST(Mac, ComparesAllOfIt) {
  const std::vector<std::uint8_t> a(32, 7);
  std::vector<std::uint8_t> b = a;
  EXPECT_TRUE(same_mac(a, b));
  b[31] = 6;
  EXPECT_FALSE(same_mac(a, b));
  b.pop_back();
  EXPECT_FALSE(same_mac(a, b));
}

class SecretFiles : public testing::Test {
 protected:
  std::string problem(const std::string& text, mode_t mode = 0600) {
    const auto file = folder_.write("secret", text);
    chmod(file.c_str(), mode);
    return read_secret(file).problem;
  }
  const TemporaryFolder folder_;
};

TEST_F(SecretFiles, AreTakenWithoutTheLinesEnd) {
  const std::string text = "0123456789abcdef";
  for (const char* end : {"", "\n", "\r\n"}) {
    ASSERT_EQ(problem(text + end), "");
    const SecretFile read = read_secret(folder_.path() / "secret");
    EXPECT_EQ(read.secret->mac(bytes_of("x")), secret(text).mac(bytes_of("x")));
  }
}

TEST_F(SecretFiles, AreRefusedWhereOthersCanReadOrWriteThem) {
  const std::string good(32, 'x');
  EXPECT_EQ(problem(good, 0640), "") << "a group is of one's own choice";
  EXPECT_NE(problem(good, 0644).find("others can read it; chmod 600 it"), std::string::npos);
  EXPECT_NE(problem(good, 0604).find("others can read it"), std::string::npos);
  EXPECT_NE(problem(good, 0620).find("others can write it"), std::string::npos);
  EXPECT_NE(problem(good, 0602).find("others can write it"), std::string::npos);
}

TEST_F(SecretFiles, AreRefusedWithTooFewOrTooManyBytes) {
  const std::string few = problem("0123456789abcde\n");
  EXPECT_NE(few.find("holds 15 bytes, wanted 16 to 4096; make one: "), std::string::npos) << few;
  EXPECT_EQ(few.find("0123456789"), std::string::npos) << "never the secret itself";
  EXPECT_NE(problem("").find("holds 0 bytes"), std::string::npos);
  EXPECT_EQ(problem(std::string(4096, 'x') + "\n"), "");
  EXPECT_NE(problem(std::string(4097, 'x')), "");
  EXPECT_NE(problem(std::string(100000, 'x')), "");
}

TEST_F(SecretFiles, AreFiles) {
  EXPECT_NE(read_secret(folder_.path()).problem.find("is no file"), std::string::npos);
  EXPECT_NE(read_secret("/dev/zero").problem, "");
  const std::string none = read_secret(folder_.path() / "none").problem;
  EXPECT_NE(none.find("none: cannot be read: No such file"), std::string::npos) << none;
}

}  // namespace
}  // namespace eifmap
