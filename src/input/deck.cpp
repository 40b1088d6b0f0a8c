// The text of a deck and the overrides that are put into its tree before anything is read, so that
// both meet the same checks.
// Rank 0 reads the file, all parse the same text: every rank finds the same problems and throws
// alike, without a second agreement.
//
// A tree, then overrides, then one visit: order of files and words does not matter any more once
// the reader sees it. There is no second way in: whatever reaches a parameter has been checked.
#include "trackbed/input/deck.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "input/reader.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::input {

// Behind a pointer, so that the door of the room shows neither tree nor problems.
struct Deck::Text {
  std::string origin;
  Node root;
  Problems problems;    // of overrides; the rest is found by fill
  bool stored = false;  // in a checkpoint
};

namespace {

// For a message: what a user may have meant, by name where elements have names.
std::string elements_in_words(const Node& list) {
  std::string words;
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const Node* name = list.items[i].is_table() ? list.items[i].member("name") : nullptr;
    words += words.empty() ? "" : ", ";
    words += name != nullptr && name->kind == Node::Kind::text ? name->text : fmt::format("{}", i);
  }
  return words.empty() ? "it has none" : fmt::format("it has {}", words);
}

// Puts one value into the tree, making sections on the way. Returns what is wrong, or nothing.
// A name that no parameter has is not found here but by the reader, with its suggestion: this only
// walks. Elements of lists must exist, since an override cannot give a whole new one.
// Cost: a walk along the path per override.
// An override of a section that is not in the deck makes it: what it may hold is again the reader's
// to say.
std::string put(Node& root, const std::string& path, Node value) {
  Node* node = &root;
  for (const std::string& word : words_of(path)) {
    if (word.empty()) return fmt::format("\"{}\" is not the name of a parameter", path);
    if (node->is_list()) {
      Node* const found = element(*node, word);
      if (found == nullptr)
        return fmt::format("{}: there is no element {}; {}", path, word, elements_in_words(*node));
      node = found;
      continue;
    }
    if (!node->is_table())
      return fmt::format("{}: what comes before {} is a value, not a section", path, word);
    Node* next = node->member(word);
    if (next == nullptr) {
      next = &node->members.emplace_back(word, Node{}).second;
      next->commanded = true;
    }
    node = next;
  }
  *node = std::move(value);
  return "";
}

// Its line would be that of the override's own text: worse than none.
void mark_commanded(Node& node) {
  node.commanded = true;
  node.line = 0;
  for (Node& item : node.items) mark_commanded(item);
  for (auto& [name, value] : node.members) mark_commanded(value);
}

std::string stripped(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Split at the first sign: a value may hold others. Problems are kept, not thrown: they come with
// those of the deck.
void apply(const std::string& override_text, Node& root, Problems& problems) {
  static const Node on_command_line = [] {
    Node node;
    node.commanded = true;
    return node;
  }();
  const std::size_t equals = override_text.find('=');
  if (equals == std::string::npos)
    return problems.add(&on_command_line, fmt::format("\"{}\" must read key=value", override_text));
  const std::string words = stripped(override_text.substr(equals + 1));
  Node value = parse_value(words);
  mark_commanded(value);
  if (!value.is_list() && value.kind != Node::Kind::text) value.text = words;
  const std::string wrong = put(root, stripped(override_text.substr(0, equals)), std::move(value));
  if (!wrong.empty()) problems.add(&on_command_line, wrong);
}

// As bytes: line ends are the parser's.
std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

Deck::Deck(std::unique_ptr<Text> text) : text_(std::move(text)) {}
// Here, where Text is complete: the header only declares it.
Deck::~Deck() = default;
Deck::Deck(Deck&&) noexcept = default;
Deck& Deck::operator=(Deck&&) noexcept = default;

// Collective. What rank 0 cannot read is told to all before anyone parses: all throw the same
// sentence. Other ranks never look at the file, which need not be there for them.
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
  // The text travels whole: a deck has a few kilobytes.
  problem = comm.broadcast(problem);
  if (!problem.empty()) throw InputError({problem});
  return parse(comm.broadcast(text), path, overrides);
}

// Local, but to be called with the same text on all ranks.
Deck Deck::parse(const std::string& text, const std::string& origin,
                 const std::vector<std::string>& overrides) {
  auto deck = std::make_unique<Text>(origin, parse_toml(text, origin), Problems(origin));
  for (const std::string& one : overrides) apply(one, deck->root, deck->problems);
  return Deck(std::move(deck));
}

Deck Deck::stored(const std::string& text, const std::string& origin,
                  const std::vector<std::string>& overrides) {
  Deck deck = parse(text, origin, overrides);
  deck.text_->stored = true;
  return deck;
}

// The declaration is visited twice: once by the collector for all names (suggestions), once by the
// reader. It fills the variables that the declaration names; if it throws, they are half filled and
// of no use.
std::vector<std::string> Deck::fill(const Declaration& declaration) const {
  Problems problems = text_->problems;
  // Names of files in a deck count from the deck, not from where the program was called.
  const std::string folder = std::filesystem::path(text_->origin).parent_path().string();
  // Three acts: values with their problems, what is left over, and all sentences at once.
  Reader reader(text_->root, folder, all_parameters(declaration), problems);
  if (text_->stored) reader.take_origins_as_they_are();
  declaration(reader);
  reader.finish();
  problems.throw_if_any();
  return problems.warnings();
}

// "file:line: key" if the deck gives the key, else the file alone: its default is meant.
std::string Deck::where(const std::string& key) const {
  const Place place = follow(text_->root, key);
  return text_->problems.start(place.reached ? place.node : nullptr) + key;
}

bool Deck::gives(const std::string& key) const { return follow(text_->root, key).reached; }

}  // namespace trackbed::input
