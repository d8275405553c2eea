#include "server/progress_bar.h"

#include <iomanip>
#include <sstream>
#include <string>

namespace eifmap {

void ProgressBar::show(int done, int total) {
  const int steps = terminal_ ? 100 : 10;
  const int reached = total > 0 ? static_cast<int>(static_cast<long>(done) * steps / total) : steps;
  if (reached == shown_) return;
  shown_ = reached;
  const double elapsed =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  const int percent = reached * 100 / steps;
  std::ostringstream line;
  line << std::setw(3) << percent << " %  " << done << "/" << total << " images  " << std::fixed
       << std::setprecision(1) << elapsed << " s";
  if (!terminal_) {
    out_ << line.str() << std::endl;
    return;
  }
  constexpr int kWidth = 40;
  const int filled = percent * kWidth / 100;
  out_ << "\r[" << std::string(static_cast<std::size_t>(filled), '#')
       << std::string(static_cast<std::size_t>(kWidth - filled), ' ') << "] " << line.str()
       << (done == total ? "\n" : "") << std::flush;
}

}  // namespace eifmap
