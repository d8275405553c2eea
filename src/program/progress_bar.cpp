#include "program/progress_bar.h"

#include <iomanip>
#include <sstream>
#include <string>

namespace eifmap {
namespace {

std::string seconds_text(std::chrono::steady_clock::duration elapsed) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << std::chrono::duration<double>(elapsed).count()
       << " s";
  return text.str();
}

}  // namespace

void ProgressBar::show_count(int done) {
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::seconds(terminal_ ? 1 : 60);
  out_ << (terminal_ ? "\r" : "") << done << " images  " << seconds_text(now - begin_);
  if (terminal_)
    out_ << std::flush;
  else
    out_ << std::endl;
  line_open_ = terminal_;
}

ProgressBar::~ProgressBar() {
  if (line_open_) out_ << std::endl;
}

void ProgressBar::show(int done, int total) {
  if (total < 0) return show_count(done);
  const int steps = terminal_ ? 100 : 10;
  // A container may hold more than it said.
  const int reached =
      done < total ? static_cast<int>(static_cast<long>(done) * steps / total) : steps;
  if (reached == shown_) return;
  shown_ = reached;
  const int percent = reached * 100 / steps;
  std::ostringstream line;
  line << std::setw(3) << percent << " %  " << done << "/" << total << " images  "
       << seconds_text(Clock::now() - begin_);
  if (!terminal_) {
    out_ << line.str() << std::endl;
    return;
  }
  constexpr int kWidth = 40;
  const int filled = percent * kWidth / 100;
  out_ << "\r[" << std::string(static_cast<std::size_t>(filled), '#')
       << std::string(static_cast<std::size_t>(kWidth - filled), ' ') << "] " << line.str()
       << (done >= total ? "\n" : "") << std::flush;
  line_open_ = done < total;
}

}  // namespace eifmap
