// "Did you mean": the declared name with the smallest number of typing errors.
// O(letters^2) per known name; called only when something is wrong. Case is ignored: names of
// parameters are lower case.
#include <algorithm>
#include <cctype>
#include <numeric>

#include "input/lower.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::input {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

namespace {

// Insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`
// (Damerau 1964, doi:10.1145/363958.363994; restricted form, no letter is edited twice):
//   d(i,j) = min(d(i-1,j) + 1, d(i,j-1) + 1, d(i-1,j-1) + [a_i != b_j], d(i-2,j-2) + 1 at a swap).
std::size_t distance(const std::string& a, const std::string& b) {
  // Three rows of the table of distances are enough: a swap refers to two letters before.
  std::vector<std::size_t> before, last(b.size() + 1), now(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before = last;
    last = now;
  }
  return last[b.size()];
}

}  // namespace

// The first of equal distances, in the order of declaration. The bound avoids suggestions that
// nobody meant.
std::string nearest(const std::string& wrong, const std::vector<std::string>& known) {
  // A third of the letters may be wrong, and always one: long names allow more errors; short names
  // are all similar.
  std::size_t best = std::max<std::size_t>(1, wrong.size() / 3) + 1;
  std::string found;
  for (const std::string& word : known) {
    const std::size_t steps = distance(lower(wrong), lower(word));
    // Any word of one letter is one edit away from another one.
    if (steps < best && steps < std::max(wrong.size(), word.size())) best = steps, found = word;
  }
  return found;
}

}  // namespace trackbed::input
