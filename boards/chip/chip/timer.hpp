// A timer that counts up, with the outputs of its compare channels: RM0090, chapters 17 and 18.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "chip/block.hpp"
#include "chip/wire.hpp"

namespace stator::chip {

class Timer : public Block {
  public:
    enum class Bus { kApb1, kApb2 };
    // An output's pulse begins; 0: it stays low for this period.
    using Watcher = std::function<void(unsigned channel, uint64_t high_ns, uint64_t period_ns)>;

    Timer(Chip& chip, const char* name, uint32_t base, Gate gate, Bus bus, unsigned line,
          unsigned bits, unsigned channels);
    void watch(Watcher watcher) { watcher_ = std::move(watcher); }
    // Its count, until it starts again; none while it stands.
    wire::Counter counter() const;

    void reset() override;
    uint64_t due_ns() const override { return std::min(update_ns_, compare_ns_); }
    uint64_t visible_ns() const override;
    void run() override;
    void settle() override;

  private:
    uint32_t on_read(uint32_t offset) override;
    void on_write(uint32_t offset, uint32_t value) override;
    void check(uint32_t offset, uint32_t value) const;
    void update_event();
    void schedule();
    void pulse() const;
    void raise();
    uint32_t count() const;
    uint32_t clock_hz() const;
    uint64_t ns_of(uint64_t counts) const;
    bool is_on(unsigned channel) const;

    Bus bus_;
    unsigned line_;  // of updates; of TIM1, its compare channels have another one
    uint32_t mask_;  // of the counter
    unsigned channels_;
    Watcher watcher_;
    // At `from_ns_` the counter was `from_count_`; what runs is the shadow of PSC and ARR.
    uint64_t from_ns_ = 0;
    uint32_t from_count_ = 0;
    uint32_t prescaler_ = 0;
    uint32_t reload_ = 0;
    uint32_t compare_[4] = {};
    uint64_t update_ns_ = kNever;
    uint64_t compare_ns_ = kNever;
};

}  // namespace stator::chip
