// What parts on the board do by themselves, at its time.
#pragma once

#include <functional>
#include <map>
#include <utility>

#include "chip/block.hpp"

namespace stator::chip {

class Agenda : public Block {
  public:
    explicit Agenda(Chip& chip) : Block(chip, "agenda", 0, 0, {}, {}, kWords) {}
    void at(uint64_t time_ns, std::function<void()> call) {
        calls_.emplace(time_ns, std::move(call));
    }
    void reset() override {}  // the parts go on
    uint64_t due_ns() const override { return calls_.empty() ? kNever : calls_.begin()->first; }
    // In the order in which they were asked for, at one time.
    void run() override {
        const auto first = calls_.begin();
        const std::function<void()> call = std::move(first->second);
        calls_.erase(first);
        call();
    }

  private:
    std::multimap<uint64_t, std::function<void()>> calls_;
};

}  // namespace stator::chip
