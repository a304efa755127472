// The key of a vehicle, between the memory that keeps it and the lines that use it. It is in no
// topic, as topics are recorded.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "stator/mavlink/signature.hpp"

namespace stator::mav {

struct SigningKey {
    // Lost: there was one, and it cannot be read. Then no signature is good.
    enum class State : uint8_t { kNone, kSet, kLost };
    State state = State::kNone;
    SigningKeyBytes bytes{};
};

// Levels that preempt each other or run at the same time write and read it. None waits: a call that
// finds it being written does nothing, and says so.
class SharedKey {
  public:
    // What will say which key there is says that it is there. Until it has, nothing is known.
    void expect() { is_expected_.store(true, std::memory_order_relaxed); }
    bool is_known() const {
        return !is_expected_.load(std::memory_order_relaxed) ||
               version_.load(std::memory_order_acquire) != 0;
    }
    // Grows with each key; 0: none was written.
    uint32_t version() const { return version_.load(std::memory_order_acquire); }
    [[nodiscard]] bool write(const SigningKey& key);
    // If there is a newer one than `version`; which then is that one's.
    [[nodiscard]] bool read(uint32_t& version, SigningKey& key) const;

  private:
    std::atomic<uint32_t> version_{0};  // odd: it is being written
    std::atomic<bool> is_expected_{false};
    std::atomic<SigningKey::State> state_{SigningKey::State::kNone};
    std::array<std::atomic<uint8_t>, kKeyBytes> bytes_{};
};

}  // namespace stator::mav
