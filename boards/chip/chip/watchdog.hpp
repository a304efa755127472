// The independent watchdog: RM0090, chapter 21.
#pragma once

#include <algorithm>

#include "chip/block.hpp"

namespace stator::chip {

class Watchdog : public Block {
  public:
    explicit Watchdog(Chip& chip);
    uint64_t kicks() const { return kicks_; }
    void reset() override;
    uint64_t due_ns() const override { return std::min(end_ns_, updated_ns_); }
    void run() override;

  private:
    uint32_t on_read(uint32_t offset) override;
    void on_write(uint32_t offset, uint32_t value) override;
    void kick();

    bool is_open_ = false;
    uint64_t end_ns_ = kNever;
    uint64_t updated_ns_ = kNever;  // when the values have reached the slow oscillator's side
    uint64_t kicks_ = 0;
};

}  // namespace stator::chip
