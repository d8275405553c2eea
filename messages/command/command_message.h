// Commands to a running server, and its answers: the wire's own structs, checked.
#pragma once

#include <cstdint>
#include <eifmap/command_t.hpp>
#include <eifmap/reply_t.hpp>
#include <span>
#include <string>
#include <string_view>

#include "wire/bytes.h"

namespace eifmap {

inline constexpr std::size_t kMaxArguments = 16;
inline constexpr std::size_t kMaxArgument = 1024;  // characters of a key or a value
inline constexpr std::size_t kMaxValues = 256;     // of a reply
inline constexpr std::size_t kMacBytes = 32;

// What a user types, and what it takes.
struct CommandText {
  struct Argument {
    const char* key;  // nullptr: none
    bool required;
  };
  std::int16_t command;  // CMD_*
  const char* name;      // "localize-only"
  const char* what;      // what it does
  Argument arguments[2];
};

std::span<const CommandText> all_commands();
const CommandText* command_text(std::int16_t command);    // null: there is none such
const CommandText* command_named(std::string_view name);  // null
std::string_view result_name(std::int8_t result);         // "OK", ...; "UNKNOWN"

// "" where it is not given.
std::string argument(const command_t& command, std::string_view key);

// "" or what is wrong with what is given: one that is missing, or that the command does not take.
std::string arguments_problem(const command_t& command, const CommandText& text);

// Refuse with kMalformedMessage: sizes, name, time, numbers that are none, a mac of another size,
// an argument given twice. A command's code may be one that nobody knows. The texts are of any
// kind: escape them where they are shown.
Decoded<command_t> decode_command(Bytes bytes);
Decoded<reply_t> decode_reply(Bytes bytes);

}  // namespace eifmap
