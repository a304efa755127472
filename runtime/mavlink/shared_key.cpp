// The key of a vehicle.
#include "stator/mavlink/shared_key.hpp"

namespace stator::mav {

bool SharedKey::write(const SigningKey& key) {
    uint32_t version = version_.load(std::memory_order_relaxed);
    if (version % 2 != 0) return false;
    if (!version_.compare_exchange_strong(version, version + 1, std::memory_order_acquire)) {
        return false;
    }
    std::atomic_thread_fence(std::memory_order_release);
    state_.store(key.state, std::memory_order_relaxed);
    for (std::size_t i = 0; i < kKeyBytes; ++i) {
        bytes_[i].store(key.bytes[i], std::memory_order_relaxed);
    }
    version_.store(version + 2, std::memory_order_release);
    return true;
}

bool SharedKey::read(uint32_t& version, SigningKey& key) const {
    const uint32_t before = version_.load(std::memory_order_acquire);
    if (before == version || before % 2 != 0) return false;
    SigningKey found{.state = state_.load(std::memory_order_relaxed)};
    for (std::size_t i = 0; i < kKeyBytes; ++i) {
        found.bytes[i] = bytes_[i].load(std::memory_order_relaxed);
    }
    std::atomic_thread_fence(std::memory_order_acquire);
    if (version_.load(std::memory_order_relaxed) != before) return false;
    version = before;
    key = found;
    return true;
}

}  // namespace stator::mav
