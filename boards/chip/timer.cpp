#include "chip/timer.hpp"

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

constexpr uint32_t kControl1 = 0x00, kInterrupts = 0x0C, kStatus = 0x10, kEvent = 0x14,
                   kMode = 0x18, kOutputs = 0x20, kCount = 0x24, kPrescaler = 0x28, kReload = 0x2C,
                   kCompare = 0x34, kBreak = 0x44;
constexpr uint32_t kEnable = 1U << 0, kNoUpdate = 1U << 1, kUpdateByCountOnly = 1U << 2,
                   kOnePulse = 1U << 3, kPreload = 1U << 7;
constexpr uint32_t kMainOutput = 1U << 15;
constexpr Row kRows[] = {
    {kControl1, "CR1", 0, 0x03FF},
    {0x04, "CR2", 0, 0x7FFD},
    {0x08, "SMCR", 0, 0xFFF7},
    {kInterrupts, "DIER", 0, 0x7FFF},
    {kStatus, "SR", 0, 0x1EFF},
    {kEvent, "EGR", 0, 0x00FF},
    {kMode, "CCMR", 0, 0xFFFF, 0, 2},
    {kOutputs, "CCER", 0, 0xBFFF},
    {kCount, "CNT", 0, 0xFFFFFFFF},
    {kPrescaler, "PSC", 0, 0xFFFF},
    {kReload, "ARR", 0xFFFFFFFF, 0xFFFFFFFF},
    {0x30, "RCR", 0, 0x00FF},
    {kCompare, "CCR", 0, 0xFFFFFFFF, 0, 4},
    {kBreak, "BDTR", 0, 0xFFFF},
};
constexpr unsigned kTimer1CompareLine = 27;

}  // namespace

Timer::Timer(Chip& chip, const char* name, uint32_t base, Gate gate, Bus bus, unsigned line,
             unsigned bits, unsigned channels)
    : Block(chip, name, base, 0x400, kRows, gate, kHalfWordsAndWords),
      bus_(bus),
      line_(line),
      mask_(bits == 32 ? 0xFFFFFFFF : 0xFFFF),
      channels_(channels) {
    Timer::reset();
}

void Timer::reset() {
    Block::reset();
    at(kReload) = reload_ = mask_;
    prescaler_ = 0;
    from_count_ = 0;
    from_ns_ = chip_.now_ns();
    std::fill(std::begin(compare_), std::end(compare_), 0U);
    update_ns_ = compare_ns_ = kNever;
}

uint32_t Timer::clock_hz() const {
    const Clocks& clocks = chip_.clocks();
    return bus_ == Bus::kApb1 ? clocks.apb1_timer_hz : clocks.apb2_timer_hz;
}

// Rounded up, so that the count has been reached then.
uint64_t Timer::ns_of(uint64_t counts) const {
    const auto ticks = static_cast<unsigned __int128>(counts) * (prescaler_ + 1ULL) * 1'000'000'000;
    return static_cast<uint64_t>((ticks + clock_hz() - 1) / clock_hz());
}

uint32_t Timer::count() const {
    if (!has(kControl1, kEnable)) return from_count_;
    const uint64_t passed_ns = chip_.now_ns() - from_ns_;
    const auto ticks = static_cast<unsigned __int128>(passed_ns) * clock_hz() / 1'000'000'000;
    const uint64_t counted = from_count_ + static_cast<uint64_t>(ticks / (prescaler_ + 1ULL));
    return static_cast<uint32_t>(std::min<uint64_t>(counted, reload_));
}

wire::Counter Timer::counter() const {
    if (!has(kControl1, kEnable)) return {};
    return {.address = base() + kCount,
            .first = from_count_,
            .clock_hz = clock_hz(),
            .divider = prescaler_ + 1,
            .from_ns = from_ns_,
            .until_ns = update_ns_};
}

// To the start of the running count, so that no fraction of it is lost.
void Timer::settle() {
    const uint32_t counted = count();
    if (has(kControl1, kEnable)) {
        const auto ticks =
            static_cast<unsigned __int128>(counted - from_count_) * (prescaler_ + 1ULL);
        from_ns_ += static_cast<uint64_t>(ticks * 1'000'000'000 / clock_hz());
    } else {
        from_ns_ = chip_.now_ns();
    }
    from_count_ = counted;
}

uint64_t Timer::visible_ns() const {
    return has(kInterrupts, 1) ? due_ns() : compare_ns_;
}

void Timer::schedule() {
    update_ns_ = compare_ns_ = kNever;
    if (!has(kControl1, kEnable)) return;
    update_ns_ = from_ns_ + ns_of(static_cast<uint64_t>(reload_) - from_count_ + 1);
    for (unsigned i = 0; i < channels_; ++i) {
        if (!has(kInterrupts, 2U << i) || compare_[i] > reload_) continue;
        if (compare_[i] <= from_count_) continue;
        const uint64_t reached_ns = from_ns_ + ns_of(compare_[i] - from_count_);
        if (reached_ns > chip_.now_ns()) compare_ns_ = std::min(compare_ns_, reached_ns);
    }
}

void Timer::run() {
    const uint64_t now_ns = chip_.now_ns();
    if (compare_ns_ <= now_ns) {
        for (unsigned i = 0; i < channels_; ++i) {
            if (has(kInterrupts, 2U << i) && count() == compare_[i]) at(kStatus) |= 2U << i;
        }
        compare_ns_ = kNever;
    }
    if (update_ns_ <= now_ns) {
        from_ns_ = update_ns_;
        from_count_ = 0;
        if (has(kControl1, kOnePulse)) at(kControl1) &= ~kEnable;
        if (!has(kControl1, kNoUpdate)) {
            update_event();
            at(kStatus) |= 1;
        }
        pulse();
    }
    schedule();
    raise();
}

// What was written goes into effect: 18.3.1.
void Timer::update_event() {
    prescaler_ = at(kPrescaler);
    reload_ = at(kReload);
    for (unsigned i = 0; i < channels_; ++i) compare_[i] = at(kCompare + 4 * i);
}

bool Timer::is_on(unsigned channel) const {
    const bool is_main_on = name() != "TIM1" || has(kBreak, kMainOutput);
    return is_main_on && (at(kOutputs) >> 4 * channel & 1) != 0;
}

void Timer::pulse() const {
    if (!watcher_ || !has(kControl1, kEnable)) return;
    for (unsigned i = 0; i < channels_; ++i) {
        if (!is_on(i)) continue;
        // PWM mode 1, which is high below the compare value: 18.4.7.
        const uint64_t high = std::min<uint64_t>(compare_[i], reload_ + 1ULL);
        watcher_(i, ns_of(high), ns_of(reload_ + 1ULL));
    }
}

uint32_t Timer::on_read(uint32_t offset) {
    if (offset == kCount) {
        chip_.note_read_of(*this);
        return count();
    }
    return offset == kEvent ? 0 : at(offset);
}

void Timer::check(uint32_t offset, uint32_t value) const {
    if (offset == kControl1 && (value & 0x70) != 0) refuse("counting down is not modelled");
    if (offset == kInterrupts && (value & 0x7F00) != 0) refuse("its DMA is not modelled");
    if ((offset == 0x04 || offset == 0x08 || offset == 0x30) && value != 0) {
        refuse(name_of(offset) + " is not modelled");
    }
    if (offset == kEvent && (value & ~1U) != 0) refuse("EGR is modelled for updates only");
    if (offset == kMode || offset == kMode + 4) {
        for (unsigned half = 0; half < 16; half += 8) {
            const uint32_t mode = value >> half & 0xF7;
            if (mode != 0 && mode != 0x60) refuse("only PWM mode 1 is modelled: " + hex(value));
        }
    }
    if (offset == kOutputs && (value & 0x2222) != 0) refuse("inverted outputs are not modelled");
    if (mask_ == 0xFFFF && value > 0xFFFF) refuse(name_of(offset) + " gets more than 16 bits");
}

void Timer::on_write(uint32_t offset, uint32_t value) {
    check(offset, value);
    settle();
    const bool was_on = has(kControl1, kEnable);
    switch (offset) {
        case kStatus:
            at(kStatus) &= value;  // cleared by writing 0
            break;
        case kEvent:
            if ((value & 1) == 0) break;
            from_count_ = 0;
            from_ns_ = chip_.now_ns();
            if (has(kControl1, kNoUpdate)) break;
            update_event();
            if (!has(kControl1, kUpdateByCountOnly)) at(kStatus) |= 1;
            break;
        case kCount:
            from_count_ = value;
            from_ns_ = chip_.now_ns();
            break;
        default:
            at(offset) = value;
            if (offset == kReload && !has(kControl1, kPreload)) reload_ = value;
            for (unsigned i = 0; i < channels_; ++i) {
                const bool is_buffered = (at(kMode + i / 2 * 4) >> (3 + i % 2 * 8) & 1) != 0;
                if (offset == kCompare + 4 * i && !is_buffered) compare_[i] = value;
            }
    }
    if (!was_on) from_ns_ = chip_.now_ns();
    if (from_count_ > reload_) refuse("the counter is above its reload value, and counts on");
    schedule();
    raise();
}

void Timer::raise() {
    const uint32_t raised = at(kStatus) & at(kInterrupts);
    if (name() == "TIM1") {
        chip_.set_line(line_, (raised & 1) != 0);
        chip_.set_line(kTimer1CompareLine, (raised & 0x1E) != 0);
    } else {
        chip_.set_line(line_, raised != 0);
    }
}

}  // namespace stator::chip
