// The CAN controller of STM32F4 chips (bxCAN), by its registers: RM0090, chapter 32.
//
// Nothing here waits: reset, bit timing, the return from bus-off and the abort of a frame are steps
// of a state machine, one or more an activation. Other control bits stay off: the hardware sends by
// identifier (TXFP), repeats what was not acknowledged (NART), does not come back from bus-off by
// itself (ABOM), overwrites the newest of a full FIFO (RFLM), and a core that a debugger has halted
// does not disturb the bus (DBF).
#pragma once

#include <array>
#include <cstdint>

#include "../can_driver.hpp"

namespace stator::drivers::can::bxcan {

// RM0090, 32.9: offsets and bits.
inline constexpr uint32_t kMasterControl = 0x000;  // CAN_MCR
inline constexpr uint32_t kInitRequest = 1U << 0;
inline constexpr uint32_t kSleepRequest = 1U << 1;
inline constexpr uint32_t kMasterStatus = 0x004;  // CAN_MSR
inline constexpr uint32_t kInitAcknowledge = 1U << 0;
inline constexpr uint32_t kErrorInterrupt = 1U << 2;
inline constexpr uint32_t kTransmitStatus = 0x008;  // CAN_TSR; 8 bits each mailbox
inline constexpr uint32_t kRequestCompleted = 1U << 0;
inline constexpr uint32_t kTransmitOk = 1U << 1;
inline constexpr uint32_t kAbort = 1U << 7;
inline constexpr uint32_t kAbortAll = kAbort | kAbort << 8 | kAbort << 16;
inline constexpr uint32_t kFirstEmpty = 1U << 26;
inline constexpr uint32_t kAllEmpty = 7U << 26;
inline constexpr uint32_t kFifo = 0x00C;  // CAN_RF0R, CAN_RF1R
inline constexpr uint32_t kFifoPending = 3U << 0;
inline constexpr uint32_t kFifoOverrun = 1U << 4;
inline constexpr uint32_t kFifoRelease = 1U << 5;
inline constexpr uint32_t kInterruptEnable = 0x014;  // CAN_IER
inline constexpr uint32_t kMailboxEmpty = 1U << 0;
inline constexpr uint32_t kFifoNotEmpty = 1U << 1 | 1U << 4;  // of both
inline constexpr uint32_t kWarns = 1U << 8;
inline constexpr uint32_t kTurnsPassive = 1U << 9;
inline constexpr uint32_t kTurnsOff = 1U << 10;
inline constexpr uint32_t kErrors = 1U << 15;    // none of the three without it
inline constexpr uint32_t kErrorStatus = 0x018;  // CAN_ESR
inline constexpr uint32_t kErrorWarning = 1U << 0;
inline constexpr uint32_t kErrorPassive = 1U << 1;
inline constexpr uint32_t kBusOff = 1U << 2;
inline constexpr uint32_t kLastError = 7U << 4;
inline constexpr uint32_t kBitTiming = 0x01C;        // CAN_BTR
inline constexpr uint32_t kTransmitMailbox = 0x180;  // CAN_TI0R; 16 bytes each
inline constexpr uint32_t kTransmitRequest = 1U << 0;
inline constexpr uint32_t kRemote = 1U << 1;
inline constexpr uint32_t kExtended = 1U << 2;
inline constexpr uint32_t kExtendedShift = 3;
inline constexpr uint32_t kStandardShift = 21;
inline constexpr uint32_t kReceiveMailbox = 0x1B0;  // CAN_RI0R; 16 bytes each
inline constexpr uint32_t kFilterMaster = 0x200;    // CAN_FMR
inline constexpr uint32_t kFilterInit = 1U << 0;
inline constexpr uint32_t kFilterMode = 0x204;    // CAN_FM1R
inline constexpr uint32_t kFilterScale = 0x20C;   // CAN_FS1R
inline constexpr uint32_t kFilterFifo = 0x214;    // CAN_FFA1R
inline constexpr uint32_t kFilterActive = 0x21C;  // CAN_FA1R
inline constexpr uint32_t kFilterBank = 0x240;    // CAN_F0R1; 8 bytes each
inline constexpr unsigned kMailboxes = 3;

// The value of CAN_BTR for a bit rate (32.7.7), sampled at about 80 % of a bit; 0 if this clock
// cannot make it.
[[nodiscard]] uint32_t bit_timing(uint32_t clock_hz, uint32_t bit_rate);

// At the entry of a vector of the controller, which stays raised for as long as its cause does:
// keeps these interrupts out until the driver has run (`end`). False: they were out already.
// Context: at the level of the driver's task or above.
template <class Registers>
bool take_line(const Registers& registers, uint32_t interrupts) {
    const uint32_t enabled = registers.read(kInterruptEnable);
    registers.write(kInterruptEnable, enabled & ~interrupts);
    return (enabled & interrupts) != 0;
}

// The chip's own registers.
struct Memory {
    uintptr_t base;
    uint32_t read(uint32_t offset) const { return *at(offset); }
    void write(uint32_t offset, uint32_t value) const { *at(offset) = value; }

  private:
    volatile uint32_t* at(uint32_t offset) const {
        return reinterpret_cast<volatile uint32_t*>(base + offset);
    }
};

// `Registers` has read(offset) and write(offset, value). One task uses an object.
template <class Registers>
class BxcanPort {
  public:
    static constexpr uint64_t kMaxReset_us = 100'000;
    // 128 times 11 recessive bits come with 128 frames of a full bus: at 125 kbit/s some 160 ms.
    static constexpr uint64_t kMaxLeave_us = 500'000;
    static constexpr uint64_t kBusOffPause_us = 100'000;

    // `timing`: of `bxcan::bit_timing`; the clock of the controller is on already.
    BxcanPort(Registers registers, uint32_t timing) : registers_(registers), timing_(timing) {}

    void begin(uint64_t now_us);
    CanSend send(const CanFrame& frame);
    bool take_back(CanFrame& frame);
    bool receive(CanFrame& frame, uint64_t now_us);
    void end() const;
    CanInterfaceStatus::State state() const { return state_; }
    void count(CanInterfaceStatus& status) const {
        status.io_errors = io_errors_;
        status.rx_lost = overruns_;
        status.rx_ignored = rx_ignored_;
        status.bus_off_count = bus_off_count_;
    }

  private:
    using State = CanInterfaceStatus::State;
    enum class Step : uint8_t { kReset, kConfigure, kLeave, kRun, kPause, kRestart };
    struct Mailbox {
        enum class Use : uint8_t { kFree, kWaits, kAborting, kNotSent };
        CanFrame frame{};
        uint32_t identifier = 0;  // as in its register: the lower, the more urgent
        Use use = Use::kFree;
    };
    using Use = typename Mailbox::Use;

    void request_init(Step next, uint64_t now_us);
    void configure();
    void watch_errors(uint64_t now_us);
    void acknowledge();
    void abort(unsigned mailbox);
    void abort_all();
    void abort_older(uint64_t oldest_us);
    void make_room_for(uint32_t identifier);
    unsigned mailbox_for(uint32_t identifier) const;
    bool take(unsigned fifo, CanFrame& frame, uint64_t now_us);
    bool is_in_init() const {
        return (registers_.read(bxcan::kMasterStatus) & bxcan::kInitAcknowledge) != 0;
    }

    Registers registers_;
    uint32_t timing_;
    uint64_t since_us_ = 0;  // of the step
    uint64_t io_errors_ = 0;
    uint32_t overruns_ = 0;
    uint32_t rx_ignored_ = 0;
    uint32_t bus_off_count_ = 0;
    std::array<Mailbox, bxcan::kMailboxes> mailboxes_{};
    Step step_ = Step::kReset;
    State state_ = State::kDown;
};

}  // namespace stator::drivers::can::bxcan

#include "bxcan_port_steps.hpp"
