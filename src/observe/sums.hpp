// Sums of several quantities over the stones and contacts of all ranks. Private to the module.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/par/exact_totals.hpp"

namespace trackbed::observe {

// Terms of this rank for each of a list of owners (cells, sensors), then sums over all ranks, which
// are bitwise identical for any distribution of the terms. A vector or tensor has consecutive
// quantities.
class Sums {
 public:
  explicit Sums(std::size_t quantities) : quantities_(quantities) {}

  void add(std::size_t owner, std::size_t quantity, double term) {
    terms_.push_back({owner * quantities_ + quantity, term});
  }
  void add(std::size_t owner, std::size_t quantity, std::span<const double> terms) {
    for (std::size_t k = 0; k < terms.size(); ++k) add(owner, quantity + k, terms[k]);
  }
  void add(std::size_t owner, std::size_t quantity, const Vec3& term) {
    add(owner, quantity, std::span<const double>(term.data(), 3));
  }
  // [owner * quantities + quantity]; one range per quantity. Collective.
  std::vector<double> over_ranks(const par::Comm& comm, std::size_t owners) const {
    return par::exact_totals(comm, {.sums = owners * quantities_, .ranges = quantities_},
                             terms_.size(), [&](std::size_t k) { return terms_[k]; });
  }
  // The largest term of a quantity that is not negative, of each owner. Collective.
  std::vector<double> largest(const par::Comm& comm, std::size_t owners,
                              std::size_t quantity) const {
    std::vector<double> most(owners, 0.0);
    for (const par::ExactTerm& term : terms_)
      if (term.sum % quantities_ == quantity)
        most[term.sum / quantities_] = std::max(most[term.sum / quantities_], term.value);
    comm.max(std::span(most));
    return most;
  }

 private:
  std::size_t quantities_;
  std::vector<par::ExactTerm> terms_;
};

}  // namespace trackbed::observe
