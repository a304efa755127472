// The functions of BxcanPort; included by its header.
#pragma once

namespace stator::drivers::can::bxcan {

template <class Registers>
void BxcanPort<Registers>::request_init(Step next, uint64_t now_us) {
    abort_all();
    registers_.write(bxcan::kMasterControl, bxcan::kInitRequest);
    step_ = next;
    since_us_ = now_us;
}

// In initialisation mode: bit timing and filters (32.4.1, 32.7.4). The first 14 filters are those
// of CAN1 while the start of CAN2's (CAN2SB) stays where it is after reset.
template <class Registers>
void BxcanPort<Registers>::configure() {
    registers_.write(bxcan::kBitTiming, timing_);
    registers_.write(bxcan::kFilterMaster,
                     registers_.read(bxcan::kFilterMaster) | bxcan::kFilterInit);
    registers_.write(bxcan::kFilterActive, 0);
    registers_.write(bxcan::kFilterMode, 0);     // identifier and mask,
    registers_.write(bxcan::kFilterScale, 0x7);  // of 32 bits each
    // Data frames: extended ones of messages and standard ones to FIFO 0, services to FIFO 1, which
    // so has its own depth of 3. Bit 7 of an identifier tells a service (frame.hpp of DroneCAN).
    constexpr uint32_t kService = (1U << 7) << bxcan::kExtendedShift;
    constexpr uint32_t kKind = bxcan::kExtended | bxcan::kRemote;
    const std::array<std::array<uint32_t, 2>, 3> banks{
        {{bxcan::kExtended, kService | kKind},
         {kService | bxcan::kExtended, kService | kKind},
         {0, kKind}}};
    for (uint32_t i = 0; i < banks.size(); ++i) {
        registers_.write(bxcan::kFilterBank + 8 * i, banks[i][0]);
        registers_.write(bxcan::kFilterBank + 8 * i + 4, banks[i][1]);
    }
    registers_.write(bxcan::kFilterFifo, 0x2);
    registers_.write(bxcan::kFilterActive, 0x7);
    registers_.write(bxcan::kFilterMaster,
                     registers_.read(bxcan::kFilterMaster) & ~bxcan::kFilterInit);
}

template <class Registers>
void BxcanPort<Registers>::begin(uint64_t now_us) {
    acknowledge();
    switch (step_) {
        case Step::kReset:
            if (timing_ != 0) request_init(Step::kConfigure, now_us);
            break;
        case Step::kConfigure:
        case Step::kRestart:
            if (is_in_init()) {
                if (step_ == Step::kConfigure) configure();
                registers_.write(bxcan::kMasterControl, 0);
                step_ = Step::kLeave;
                since_us_ = now_us;
            } else if (now_us - since_us_ > kMaxReset_us) {
                ++io_errors_;
                step_ = Step::kReset;
            }
            break;
        case Step::kLeave:
            // 11 recessive bits in a row, or 128 times as many after bus-off (32.4.2, 32.7.6).
            if (!is_in_init() && (registers_.read(bxcan::kErrorStatus) & bxcan::kBusOff) == 0 &&
                (registers_.read(bxcan::kTransmitStatus) & bxcan::kAllEmpty) == bxcan::kAllEmpty) {
                step_ = Step::kRun;
            } else if (now_us - since_us_ > kMaxLeave_us) {
                ++io_errors_;
                step_ = Step::kReset;
            }
            break;
        case Step::kRun:
            if (now_us > kMaxCanWait_us) abort_older(now_us - kMaxCanWait_us);
            break;
        case Step::kPause:
            if (now_us - since_us_ >= kBusOffPause_us) request_init(Step::kRestart, now_us);
            break;
    }
    if (step_ == Step::kRun) watch_errors(now_us);
}

// 32.7.6.
template <class Registers>
void BxcanPort<Registers>::watch_errors(uint64_t now_us) {
    const uint32_t errors = registers_.read(bxcan::kErrorStatus);
    // 7 is written so that the next error shows; 0 is none.
    const uint32_t last = errors & bxcan::kLastError;
    if (last != 0 && last != bxcan::kLastError) ++io_errors_;
    registers_.write(bxcan::kErrorStatus, bxcan::kLastError);
    if ((errors & bxcan::kBusOff) != 0) {
        ++bus_off_count_;
        abort_all();
        state_ = State::kBusOff;
        step_ = Step::kPause;
        since_us_ = now_us;
        return;
    }
    state_ = (errors & bxcan::kErrorPassive) != 0   ? State::kErrorPassive
             : (errors & bxcan::kErrorWarning) != 0 ? State::kErrorWarning
                                                    : State::kErrorActive;
}

// An aborted request completes like another: at once, or with the transmission that has begun,
// which may still succeed (32.7.1).
template <class Registers>
void BxcanPort<Registers>::acknowledge() {
    registers_.write(bxcan::kMasterStatus, bxcan::kErrorInterrupt);
    const uint32_t status = registers_.read(bxcan::kTransmitStatus);
    for (unsigned i = 0; i < bxcan::kMailboxes; ++i) {
        Mailbox& mailbox = mailboxes_[i];
        const bool waits = mailbox.use == Use::kWaits || mailbox.use == Use::kAborting;
        if (waits && (status & (bxcan::kFirstEmpty << i)) != 0) {
            const bool sent = (status & (bxcan::kTransmitOk << (8 * i))) != 0;
            mailbox.use = sent ? Use::kFree : Use::kNotSent;
        }
        const uint32_t completed = bxcan::kRequestCompleted << (8 * i);
        if ((status & completed) != 0) registers_.write(bxcan::kTransmitStatus, completed);
    }
}

template <class Registers>
void BxcanPort<Registers>::abort(unsigned mailbox) {
    registers_.write(bxcan::kTransmitStatus, bxcan::kAbort << (8 * mailbox));
    mailboxes_[mailbox].use = Use::kAborting;
}

template <class Registers>
void BxcanPort<Registers>::abort_all() {
    registers_.write(bxcan::kTransmitStatus, bxcan::kAbortAll);
    for (Mailbox& mailbox : mailboxes_) {
        if (mailbox.use == Use::kWaits) mailbox.use = Use::kAborting;
    }
}

template <class Registers>
void BxcanPort<Registers>::abort_older(uint64_t oldest_us) {
    for (unsigned i = 0; i < bxcan::kMailboxes; ++i) {
        if (mailboxes_[i].use == Use::kWaits && mailboxes_[i].frame.timestamp < oldest_us) abort(i);
    }
}

// A frame more urgent than all that wait takes the place of the least urgent, of one identifier the
// last: else it would wait behind them for as long as others on the bus are in between.
template <class Registers>
void BxcanPort<Registers>::make_room_for(uint32_t identifier) {
    unsigned least_urgent = 0;
    for (unsigned i = 0; i < bxcan::kMailboxes; ++i) {
        const Mailbox& mailbox = mailboxes_[i];
        if (mailbox.use != Use::kWaits || mailbox.identifier <= identifier) return;
        if (mailbox.identifier >= mailboxes_[least_urgent].identifier) least_urgent = i;
    }
    abort(least_urgent);
}

// Of mailboxes that wait, the controller sends the lowest identifier first, and of equal ones the
// lowest mailbox (32.7.1). So a frame goes above those of its own identifier, to keep their order,
// and not before it is known whether an aborted one of them was sent; and the last free mailbox is
// for one that is more urgent than what waits in the others.
template <class Registers>
unsigned BxcanPort<Registers>::mailbox_for(uint32_t identifier) const {
    unsigned lowest = 0;
    unsigned used = 0;
    bool most_urgent = true;
    for (unsigned i = 0; i < bxcan::kMailboxes; ++i) {
        const Mailbox& mailbox = mailboxes_[i];
        if (mailbox.use == Use::kFree) continue;
        ++used;
        if (mailbox.identifier <= identifier) most_urgent = false;
        if (mailbox.identifier != identifier) continue;
        if (mailbox.use != Use::kWaits) return bxcan::kMailboxes;
        lowest = i + 1;
    }
    if (used == bxcan::kMailboxes - 1 && !most_urgent) return bxcan::kMailboxes;
    unsigned i = lowest;
    while (i < bxcan::kMailboxes && mailboxes_[i].use != Use::kFree) ++i;
    return i;
}

template <class Registers>
CanSend BxcanPort<Registers>::send(const CanFrame& frame) {
    if (step_ != Step::kRun) return CanSend::kFull;
    const uint32_t identifier = frame.extended
                                    ? (frame.id << bxcan::kExtendedShift) | bxcan::kExtended
                                    : frame.id << bxcan::kStandardShift;
    const unsigned mailbox = mailbox_for(identifier);
    if (mailbox == bxcan::kMailboxes) {
        make_room_for(identifier);
        return CanSend::kFull;
    }
    const uint32_t at = bxcan::kTransmitMailbox + 16 * mailbox;
    const auto word = [&](unsigned first) {
        return static_cast<uint32_t>(frame.data[first] | (frame.data[first + 1] << 8) |
                                     (frame.data[first + 2] << 16)) |
               static_cast<uint32_t>(frame.data[first + 3]) << 24;
    };
    registers_.write(at + 4, frame.length);
    registers_.write(at + 8, word(0));
    registers_.write(at + 12, word(4));
    registers_.write(at, identifier | bxcan::kTransmitRequest);
    mailboxes_[mailbox] = {frame, identifier, Use::kWaits};
    return CanSend::kSent;
}

template <class Registers>
bool BxcanPort<Registers>::take_back(CanFrame& frame) {
    for (unsigned i = bxcan::kMailboxes; i > 0; --i) {
        Mailbox& mailbox = mailboxes_[i - 1];
        if (mailbox.use != Use::kNotSent) continue;
        frame = mailbox.frame;
        mailbox.use = Use::kFree;
        return true;
    }
    return false;
}

// One frame of a FIFO, which is then released (32.7.3). False: it is empty.
template <class Registers>
bool BxcanPort<Registers>::take(unsigned fifo, CanFrame& frame, uint64_t now_us) {
    const uint32_t fifo_register = bxcan::kFifo + 4 * fifo;
    const uint32_t status = registers_.read(fifo_register);
    if ((status & bxcan::kFifoOverrun) != 0) {
        ++overruns_;
        registers_.write(fifo_register, bxcan::kFifoOverrun);
    }
    // Until the release is done, the count may still be the old one: then try at the next
    // activation.
    if ((status & bxcan::kFifoPending) == 0 || (status & bxcan::kFifoRelease) != 0) return false;
    const uint32_t at = bxcan::kReceiveMailbox + 16 * fifo;
    const uint32_t identifier = registers_.read(at);
    const bool extended = (identifier & bxcan::kExtended) != 0;
    const uint32_t length = registers_.read(at + 4) & 0xF;
    frame = {.timestamp_sample = now_us,
             .id = identifier >> (extended ? bxcan::kExtendedShift : bxcan::kStandardShift),
             .extended = extended,
             .length = static_cast<uint8_t>(length > 8 ? 8 : length)};
    const std::array<uint32_t, 2> words{registers_.read(at + 8), registers_.read(at + 12)};
    for (unsigned i = 0; i < frame.length; ++i) {
        frame.data[i] = static_cast<uint8_t>(words[i / 4] >> (8 * (i % 4)));
    }
    registers_.write(fifo_register, bxcan::kFifoRelease);
    if ((identifier & bxcan::kRemote) == 0) return true;
    ++rx_ignored_;
    return false;
}

template <class Registers>
bool BxcanPort<Registers>::receive(CanFrame& frame, uint64_t now_us) {
    if (step_ != Step::kRun) return false;
    return take(1, frame, now_us) || take(0, frame, now_us);
}

// An interrupt from here on brings the next activation. Only those that it would acknowledge are
// enabled: others would raise their vector for ever. A change of the controller's state counts only
// if the new one is worse.
template <class Registers>
void BxcanPort<Registers>::end() const {
    uint32_t interrupts = 0;
    if (step_ == Step::kRun) {
        interrupts =
            bxcan::kMailboxEmpty | bxcan::kFifoNotEmpty | bxcan::kErrors | bxcan::kTurnsOff;
        if (state_ < State::kErrorPassive) interrupts |= bxcan::kTurnsPassive;
        if (state_ < State::kErrorWarning) interrupts |= bxcan::kWarns;
    }
    registers_.write(bxcan::kInterruptEnable, interrupts);
}

}  // namespace stator::drivers::can::bxcan
