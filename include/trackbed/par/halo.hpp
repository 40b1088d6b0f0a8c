// A fixed pattern of point-to-point messages, set up once and used many times: each rank sends
// chosen items of a local array and receives into consecutive places. Each call costs one message
// per neighbour; nothing is allocated after `connect`.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "trackbed/par/comm.hpp"

namespace trackbed::par {

class Halo {
 public:
  Halo() = default;
  // send_items[r]: local indices sent to rank r, in order (own rank: empty). Collective.
  // Received items arrive ordered by rank, then as the sender listed them.
  void connect(const Comm& comm, const std::vector<std::vector<std::int32_t>>& send_items);

  std::size_t sent() const { return items_.size(); }
  std::size_t received() const { return received_; }
  std::span<const std::int32_t> items() const { return items_; }  // what is sent, all ranks in turn

  // Sends data[items], receives into `ghosts` (size received()).
  template <class T>
  void forward(const T* data, T* ghosts) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (neighbours_.empty()) return;
    send_.resize(items_.size() * sizeof(T));
    T* packed = reinterpret_cast<T*>(send_.data());
    for (std::size_t k = 0; k < items_.size(); ++k) packed[k] = data[items_[k]];
    transfer(sizeof(T), reinterpret_cast<std::byte*>(ghosts), Direction::forward);
  }
  // Reverse transfer: every ghost's value goes to the rank it came from; `returned` (size sent())
  // is ordered like items().
  template <class T>
  void backward(const T* ghosts, T* returned) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (neighbours_.empty()) return;
    send_.resize(received_ * sizeof(T));
    if (received_ > 0) __builtin_memcpy(send_.data(), ghosts, send_.size());  // no null pointer
    transfer(sizeof(T), reinterpret_cast<std::byte*>(returned), Direction::backward);
  }

 private:
  enum class Direction { forward, backward };
  struct Neighbour {
    int rank;
    std::size_t send_begin, send_count, receive_begin, receive_count;
  };
  void transfer(std::size_t item_bytes, std::byte* target, Direction direction);

  std::vector<Comm> comm_;  // empty until connected
  std::vector<Neighbour> neighbours_;
  std::vector<std::int32_t> items_;
  std::vector<std::byte> send_;
  std::size_t received_ = 0;
};

}  // namespace trackbed::par
