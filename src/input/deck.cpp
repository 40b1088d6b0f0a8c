// The text of a deck and its overrides. Overrides are put into the parsed tree before any parameter
// is read, so that both pass the same checks.
// Rank 0 reads the file and all ranks parse the same text: every rank has the same problems and
// throws the same error, without further communication.
#include "trackbed/input/deck.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "input/reader.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::input {

// Behind a pointer, so that the public header includes neither the tree nor the problems.
struct Deck::Text {
  std::string origin;
  Node root;
  Problems problems;    // of overrides; the rest is found by fill
  bool stored = false;  // in a checkpoint
};

namespace {

// For messages: the elements of a list, by name where they have one, else by number.
std::string elements_in_words(const Node& list) {
  std::string words;
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const Node* name = list.items[i].is_table() ? list.items[i].member("name") : nullptr;
    words += words.empty() ? "" : ", ";
    words += name != nullptr && name->kind == Node::Kind::text ? name->text : fmt::format("{}", i);
  }
  return words.empty() ? "the list is empty" : fmt::format("its elements: {}", words);
}

// Puts one value into the tree and creates missing sections on the path. Returns what is wrong, or
// nothing. Unknown names are not detected here but by the reader, which suggests the nearest one.
// Elements of lists must exist, since an override cannot define a new one.
// Cost: a walk along the path per override.
std::string put(Node& root, const std::string& path, Node value) {
  Node* node = &root;
  std::string above;
  for (const std::string& word : words_of(path)) {
    if (word.empty()) return fmt::format("\"{}\" is not the name of a parameter", path);
    if (node->is_list()) {
      Node* const found = element(*node, word);
      if (found == nullptr)
        return fmt::format("{}: the list has no element {}; {}", path, word,
                           elements_in_words(*node));
      node = found;
      above += '.' + word;
      continue;
    }
    if (!node->is_table()) return fmt::format("{}: {} is a value, not a section", path, above);
    Node* next = node->member(word);
    if (next == nullptr) {
      node->members.push_back({word, Node{}});
      next = &node->members.back().value;
      next->from_override = true;
    }
    node = next;
    above += (above.empty() ? "" : ".") + word;
  }
  *node = std::move(value);
  return "";
}

// The line would be that within the override's own text, which would mislead.
void mark_override(Node& node) {
  node.from_override = true;
  node.line = 0;
  for (Node& item : node.items) mark_override(item);
  for (auto& [name, value] : node.members) mark_override(value);
}

std::string stripped(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Splits at the first '=', since a value may contain others. Problems are collected and reported
// together with those of the deck.
void apply(const std::string& override_text, Node& root, Problems& problems) {
  static const Node on_command_line = [] {
    Node node;
    node.from_override = true;
    return node;
  }();
  const std::size_t equals = override_text.find('=');
  if (equals == std::string::npos)
    return problems.add(&on_command_line,
                        fmt::format("\"{}\" must have the form key=value", override_text));
  const std::string words = stripped(override_text.substr(equals + 1));
  Node value = parse_value(words);
  mark_override(value);
  const std::string wrong = put(root, stripped(override_text.substr(0, equals)), std::move(value));
  if (!wrong.empty()) problems.add(&on_command_line, wrong);
}

// Read as bytes: the parser handles line ends.
std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

Deck::Deck(std::unique_ptr<Text> text) : text_(std::move(text)) {}
// Defined here, where Text is complete: the header only declares it.
Deck::~Deck() = default;
Deck::Deck(Deck&&) noexcept = default;
Deck& Deck::operator=(Deck&&) noexcept = default;

// Collective. If rank 0 cannot read the file, the reason is broadcast before anyone parses, and all
// ranks throw the same error. Other ranks do not access the file, which need not exist on their
// nodes.
Deck Deck::read(const par::Comm& comm, const std::string& path,
                const std::vector<std::string>& overrides) {
  std::string problem, text;
  if (comm.root()) {
    std::error_code error;
    if (!std::filesystem::exists(path, error))
      problem = fmt::format("{}: does not exist", path);
    else if (!std::filesystem::is_regular_file(path, error) || !std::ifstream(path))
      problem = fmt::format("{}: cannot be read", path);
    else
      text = text_of(path);
  }
  // The whole text is broadcast: a deck has a few kilobytes.
  problem = comm.broadcast(problem);
  if (!problem.empty()) throw InputError({problem});
  return parse(comm.broadcast(text), path, overrides);
}

// Local, but must be called with the same text on all ranks.
Deck Deck::parse(const std::string& text, const std::string& origin,
                 const std::vector<std::string>& overrides) {
  auto deck = std::make_unique<Text>(Text{origin, parse_toml(text, origin), Problems(origin)});
  for (const std::string& one : overrides) apply(one, deck->root, deck->problems);
  return Deck(std::move(deck));
}

Deck Deck::stored(const std::string& text, const std::string& origin,
                  const std::vector<std::string>& overrides) {
  Deck deck = parse(text, origin, overrides);
  deck.text_->stored = true;
  return deck;
}

// The declaration is visited twice: by the collector for all names (suggestions), then by the
// reader, which fills the declared variables. If it throws, they are partly filled and must not be
// used.
std::vector<std::string> Deck::fill(const Declaration& declaration) const {
  Problems problems = text_->problems;
  // File names in a deck are relative to the deck's folder, not to the working directory.
  const std::string folder = std::filesystem::path(text_->origin).parent_path().string();
  // Three steps: read the values, report unknown names, report all problems at once.
  Reader reader(text_->root, folder, all_parameters(declaration), problems);
  if (text_->stored) reader.accept_missing_origins();
  declaration(reader);
  reader.finish();
  problems.throw_if_any();
  return problems.warnings();
}

// "file:line: key" if the deck sets the key, else "file: key": the default applies.
std::string Deck::where(const std::string& key) const {
  const Place place = follow(text_->root, key);
  return text_->problems.start(place.reached ? place.node : nullptr) + key;
}

std::string Deck::located(const std::string& sentence) const {
  constexpr const char* of_keys = "abcdefghijklmnopqrstuvwxyz0123456789_.[]";
  const std::size_t end = std::min(sentence.find_first_not_of(of_keys), sentence.size());
  const std::string key = sentence.substr(0, end), top = key.substr(0, key.find_first_of(".["));
  return sets(top) ? where(key) + sentence.substr(end) : sentence;
}

bool Deck::sets(const std::string& key) const { return follow(text_->root, key).reached; }

}  // namespace trackbed::input
