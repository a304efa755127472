// What parts on the board do by themselves, at its time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "chip/block.hpp"

namespace stator::chip {

// Whether the chip's processor may notice what happens.
enum class Effect : uint8_t { kSeen, kUnseen };

class Agenda : public Block {
  public:
    explicit Agenda(Chip& chip) : Block(chip, "agenda", 0, 0, {}, {}, kWords) {}
    void at(uint64_t time_ns, Effect effect, std::function<void()> call) {
        calls_.emplace(time_ns, Entry{effect, std::move(call)});
    }
    void reset() override {}  // the parts go on
    uint64_t due_ns() const override { return calls_.empty() ? kNever : calls_.begin()->first; }
    uint64_t visible_ns() const override {
        const auto is_seen = [](const auto& call) { return call.second.effect == Effect::kSeen; };
        const auto first = std::ranges::find_if(calls_, is_seen);
        return first == calls_.end() ? kNever : first->first;
    }
    // In the order in which they were asked for, at one time.
    void run() override {
        const auto first = calls_.begin();
        const std::function<void()> call = std::move(first->second.call);
        calls_.erase(first);
        call();
    }

  private:
    struct Entry {
        Effect effect;
        std::function<void()> call;
    };
    std::multimap<uint64_t, Entry> calls_;
};

}  // namespace stator::chip
