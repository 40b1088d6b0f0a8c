// Communicator: collective operations and agreement on errors; MPI behind values and spans. Every
// call is collective unless stated otherwise. Types that are sent must be trivially copyable.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace trackbed::par {

// Owns MPI_Init/MPI_Finalize; one per program. A test or program creates it first in main.
class Environment {
 public:
  Environment(int& argc, char**& argv);
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
};

class Comm {
 public:
  static Comm world();
  static Comm self();  // this rank alone

  int rank() const { return rank_; }
  int size() const { return size_; }
  bool root() const { return rank_ == 0; }

  void barrier() const;
  // Reductions over ranks; the result is the same on all. Sums of doubles depend on the number of
  // ranks: where results must be bitwise identical, sum integers (core/exact_sum.hpp).
  double sum(double value) const;
  double max(double value) const;
  double min(double value) const;
  std::int64_t sum(std::int64_t value) const;
  std::int64_t max(std::int64_t value) const;
  void sum(std::span<std::int64_t> values) const;         // in place
  void sum(std::span<double> values) const;               // in place
  void max(std::span<double> values) const;               // in place
  std::int64_t exclusive_scan(std::int64_t value) const;  // sum over lower ranks

  // All ranks' items, in rank order.
  template <class T>
  std::vector<T> all_gather(std::span<const T> mine) const {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::vector<std::byte> bytes = all_gather_bytes(std::as_bytes(mine));
    return from_bytes<T>(bytes);
  }
  // Item lists for each rank in `out` (size() of them); returns the lists that all ranks sent to
  // this one, its own among them.
  template <class T>
  std::vector<std::vector<T>> exchange(const std::vector<std::vector<T>>& out) const {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<std::span<const std::byte>> spans;
    for (const auto& list : out) spans.push_back(std::as_bytes(std::span(list)));
    std::vector<std::vector<T>> in;
    for (const auto& bytes : exchange_bytes(spans)) in.push_back(from_bytes<T>(bytes));
    const auto self = static_cast<std::size_t>(rank_);
    in[self] = out[self];
    return in;
  }
  std::string broadcast(const std::string& text) const;  // rank 0's text

  // The text of the lowest rank whose text is not empty; empty if there is none.
  std::string first_problem(const std::string& problem) const;
  // Agreement on failure: if any rank passes a non-empty problem, every rank throws RunError with
  // the text of the lowest such rank (prefixed by its rank).
  void agree(const std::string& problem) const;

  void* native() const { return handle_.get(); }  // MPI_Comm*, see par/mpi.hpp

 private:
  explicit Comm(std::shared_ptr<void> handle);
  std::vector<std::byte> all_gather_bytes(std::span<const std::byte> mine) const;
  // The list for this rank itself is not sent, and is empty in the result.
  std::vector<std::vector<std::byte>> exchange_bytes(
      const std::vector<std::span<const std::byte>>& out) const;
  template <class T>
  static std::vector<T> from_bytes(std::span<const std::byte> bytes) {
    std::vector<T> items(bytes.size() / sizeof(T));
    if (!items.empty()) __builtin_memcpy(items.data(), bytes.data(), bytes.size());
    return items;
  }

  std::shared_ptr<void> handle_;
  int rank_ = 0, size_ = 1;
};

}  // namespace trackbed::par
