#include "trackbed/model/effective.hpp"

namespace trackbed::model {

input::Declaration declaration_of(Model& model) {
  return [&model](input::Section& section) { model.declare(section); };
}

// Includes what the run started from: a result states its origin, and a resumed run may begin with
// any stage. The files themselves are not read again.
std::string effective_deck(const Model& model) {
  Model copy = model;  // `declare` is not const; here it changes no value
  return input::effective(declaration_of(copy));
}

}  // namespace trackbed::model
