#include "model/scheme/passage.hpp"
#include "model/scheme/staged.hpp"

namespace trackbed::model {

std::unique_ptr<Scheme> make_scheme(RunContext& context,
                                    const std::vector<bed::PlacedShape>& shapes) {
  if (context.model.has_stages()) return std::make_unique<StagedScheme>(context, shapes);
  return std::make_unique<PassageScheme>(context);
}

}  // namespace trackbed::model
