// Log lines at intervals during long operations.
#include "model/scheme/waiting.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace trackbed::model::waiting_test {
namespace {

using clock = std::chrono::steady_clock;

struct Lines {
  std::mutex alone;
  std::vector<std::string> entries;
  Waiting::Say say() {
    return [this](const std::string& line) {
      const std::lock_guard lock(alone);
      entries.push_back(line);
    };
  }
  std::size_t count() {
    const std::lock_guard lock(alone);
    return entries.size();
  }
};

TEST(Waiting, ReportsTheElapsedTimeAtEachInterval) {
  Lines lines;
  {
    const Waiting waiting("solving", 0.01, lines.say());
    constexpr auto patience = std::chrono::seconds(20);
    for (const auto begin = clock::now(); lines.count() < 3 && clock::now() - begin < patience;)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_GE(lines.entries.size(), 3u);
  for (std::size_t k = 0; k < lines.entries.size(); ++k) {
    ASSERT_EQ(lines.entries[k].find("solving: "), 0u) << lines.entries[k];
    EXPECT_GE(std::stod(lines.entries[k].substr(9)), 0.00995 * static_cast<double>(k + 1));
  }
  const std::size_t before = lines.entries.size();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(lines.count(), before);  // no lines after its end
}

TEST(Waiting, EndsAtOnceAndReportsNothingBeforeTheFirstInterval) {
  Lines lines;
  const auto begin = clock::now();
  { const Waiting waiting("solving", 1000, lines.say()); }
  EXPECT_LT(std::chrono::duration<double>(clock::now() - begin).count(), 100);
  EXPECT_EQ(lines.count(), 0u);
}

}  // namespace
}  // namespace trackbed::model::waiting_test
