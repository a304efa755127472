// The registers of bxCAN as RM0090, chapter 32 describes them: what a driver sees of mailboxes,
// FIFOs, filters, initialisation and errors. No bits and no time; the test says when something
// happens. Offsets and bits are written out a second time, so that a wrong one in the driver shows.
//
// Where the manual leaves something open, the model takes what is worse for a driver: a mailbox
// keeps its request through initialisation and bus-off, and what was written to a register that is
// protected just then is ignored, and counted.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

namespace stator::testing {

class BxcanModel {
  public:
    static constexpr unsigned kMailboxes = 3;
    static constexpr unsigned kNone = kMailboxes;
    static constexpr uint32_t kAckError = 3;  // a code of CAN_ESR.LEC

    struct Message {
        uint32_t identifier = 0;  // as CAN_TIxR, without the request
        uint32_t length = 0;
        std::array<uint32_t, 2> words{};
    };

    uint32_t read(uint32_t offset) {
        if (offset == 0x004) return master_status();
        if (offset == 0x008) return transmit_status();
        if (offset == 0x00C || offset == 0x010) return fifo_status((offset - 0x00C) / 4);
        if (offset == 0x018) return error_status();
        if (offset >= 0x1B0 && offset < 0x1D0) return received(offset - 0x1B0);
        return plain_[offset];
    }
    void write(uint32_t offset, uint32_t value) {
        if (offset == 0x000) return write_control(value);
        if (offset == 0x004) {
            if ((value & 1U << 2) != 0) error_interrupt_ = false;
        } else if (offset == 0x008) {
            write_transmit_status(value);
        } else if (offset == 0x00C || offset == 0x010) {
            write_fifo((offset - 0x00C) / 4, value);
        } else if (offset == 0x018) {
            last_error_ = value >> 4 & 7U;
        } else if (offset >= 0x180 && offset < 0x1B0) {
            write_mailbox((offset - 0x180) / 16, (offset - 0x180) % 16, value);
        } else if (is_protected(offset)) {
            ++violations_;
        } else {
            plain_[offset] = value;
        }
    }

    // --- the bus ---

    // The most urgent request begins to be sent, if the bus is free: the lowest identifier, of
    // equal ones the lowest mailbox (32.7.1, TXFP = 0). Which mailbox.
    unsigned begin_transmission() {
        if (sending_ != kNone || !takes_part()) return sending_;
        for (unsigned i = kMailboxes; i > 0; --i) {
            if (mailboxes_[i - 1].waits && (sending_ == kNone || is_before(i - 1, sending_))) {
                sending_ = i - 1;
            }
        }
        return sending_;
    }
    // It was acknowledged.
    std::optional<Message> end_transmission() {
        if (sending_ == kNone) return std::nullopt;
        Mailbox& mailbox = mailboxes_[sending_];
        sending_ = kNone;
        if (transmit_errors_ != 0) --transmit_errors_;
        last_error_ = 0;
        complete(mailbox, kOk);
        return mailbox.message;
    }
    // It was not: TEC rises by 8, and the request is repeated if it is not aborted (NART = 0). An
    // error-passive node that only lacks its acknowledgement counts no further (ISO 11898-1).
    void fail_transmission(uint32_t code) {
        if (sending_ == kNone) return;
        if (code != kAckError || transmit_errors_ < 128) count_errors(transmit_errors_ + 8);
        last_error_ = code;
        stop_transmission(kError);
    }
    // Another node's frame was more urgent.
    void lose_arbitration() { stop_transmission(kLost); }
    std::optional<Message> transmit() {
        begin_transmission();
        return end_transmission();
    }
    // A frame of another node: to the FIFO of the first bank that lets it pass.
    void receive(const Message& message) {
        if (!takes_part()) return;
        for (uint32_t bank = 0; bank < 28; ++bank) {
            const bool on = ((plain_[0x21C] >> bank) & 1) != 0 && (plain_[0x200] & 1) == 0;
            const bool is_ours = bank < (plain_[0x200] >> 8 & 0x3F);
            if (!on || !is_ours || !passes(bank, message.identifier)) continue;
            store((plain_[0x214] >> bank) & 1, message);
            return;
        }
    }
    // Sequences of 11 recessive bits: one ends initialisation, 128 of them bus-off (32.4.2,
    // 32.7.6). In initialisation mode nobody counts them.
    void recessive(unsigned sequences) {
        if ((plain_[0x000] & 1) != 0 || sequences == 0 || !answers_) return;
        initialising_ = false;
        if (!bus_off_ || !may_recover_) return;
        recessive_ += sequences;
        if (recessive_ < 128) return;
        bus_off_ = false;
        count_errors(0);
    }
    void count_errors(unsigned errors) {
        const bool off = errors > 255;
        const uint32_t enabled = plain_[0x014];
        const auto passes_limit = [&](unsigned limit, unsigned bit) {
            if (transmit_errors_ < limit && errors >= limit && (enabled & 1U << bit) != 0) {
                error_interrupt_ = true;
            }
        };
        passes_limit(96, 8);
        passes_limit(128, 9);
        passes_limit(256, 10);
        transmit_errors_ = off ? 256 : errors;
        if (!off || bus_off_) return;
        bus_off_ = true;
        may_recover_ = false;
        recessive_ = 0;
        sending_ = kNone;
    }
    void set_answering(bool answers) { answers_ = answers; }
    void set_heeding_aborts(bool heeds) { heeds_aborts_ = heeds; }
    void set_slow_release(bool slow) { slow_release_ = slow; }
    // After a release that took its time.
    void finish_release() {
        for (unsigned fifo = 0; fifo < 2; ++fifo) {
            if (releasing_[fifo]) fifos_[fifo].pop_front();
            releasing_[fifo] = false;
        }
    }

    // --- what a test looks at ---

    // The level of each vector (32.8).
    bool raises_sent() const { return (plain(0x014) & 1) != 0 && completed() != 0; }
    bool raises_received(unsigned fifo) const {
        return (plain(0x014) & 1U << (1 + 3 * fifo)) != 0 && !fifos_[fifo].empty();
    }
    bool raises_changed() const { return (plain(0x014) & 1U << 15) != 0 && error_interrupt_; }
    uint32_t plain(uint32_t offset) const {
        const auto found = plain_.find(offset);
        return found == plain_.end() ? 0 : found->second;
    }
    unsigned violations() const { return violations_; }
    unsigned waiting() const {
        unsigned count = 0;
        for (const auto& mailbox : mailboxes_) count += mailbox.waits ? 1 : 0;
        return count;
    }

  private:
    static constexpr uint32_t kCompleted = 1U << 0;  // of a mailbox's 8 bits of CAN_TSR
    static constexpr uint32_t kOk = 1U << 1;
    static constexpr uint32_t kLost = 1U << 2;
    static constexpr uint32_t kError = 1U << 3;

    struct Mailbox {
        Message message{};
        uint32_t status = 0;
        bool waits = false;
        bool aborting = false;
    };

    bool takes_part() const { return !initialising_ && !sleeping_ && !bus_off_; }
    bool is_before(unsigned a, unsigned b) const {
        return mailboxes_[a].message.identifier <= mailboxes_[b].message.identifier;
    }
    static void complete(Mailbox& mailbox, uint32_t status) {
        mailbox.waits = false;
        mailbox.aborting = false;
        mailbox.status |= kCompleted | status;
    }
    void stop_transmission(uint32_t status) {
        if (sending_ == kNone) return;
        Mailbox& mailbox = mailboxes_[sending_];
        sending_ = kNone;
        mailbox.status |= status;
        if (mailbox.aborting) complete(mailbox, 0);
    }
    uint32_t completed() const {
        uint32_t all = 0;
        for (const auto& mailbox : mailboxes_) all |= mailbox.status & kCompleted;
        return all;
    }

    uint32_t master_status() const {
        return (initialising_ ? 1U : 0U) | (sleeping_ ? 2U : 0U) | (error_interrupt_ ? 4U : 0U);
    }
    // 32.4: with SLEEP set there is no way into initialisation; out of it the bus must be idle.
    void write_control(uint32_t value) {
        plain_[0x000] = value;
        if (!answers_) return;
        if ((value & 2) == 0) sleeping_ = false;
        if ((value & 1) != 0 && !sleeping_) {
            initialising_ = true;
            may_recover_ = true;
        }
    }
    uint32_t transmit_status() const {
        uint32_t status = 0;
        for (unsigned i = 0; i < kMailboxes; ++i) {
            status |= mailboxes_[i].status << (8 * i);
            if (!mailboxes_[i].waits) status |= 1U << (26 + i);
        }
        return status;
    }
    // Written ones of RQCP clear the mailbox's status; ABRQ aborts at once what is not being sent.
    void write_transmit_status(uint32_t value) {
        for (unsigned i = 0; i < kMailboxes; ++i) {
            Mailbox& mailbox = mailboxes_[i];
            const uint32_t bits = value >> (8 * i);
            if ((bits & kCompleted) != 0) mailbox.status = 0;
            if ((bits & 1U << 7) == 0 || !mailbox.waits || !heeds_aborts_) continue;
            mailbox.aborting = true;
            if (sending_ != i) complete(mailbox, 0);
        }
    }
    uint32_t fifo_status(unsigned fifo) const {
        const auto count = static_cast<uint32_t>(fifos_[fifo].size());
        return count | (count == 3 ? 1U << 3 : 0) | (overrun_[fifo] ? 1U << 4 : 0) |
               (releasing_[fifo] ? 1U << 5 : 0);
    }
    void write_fifo(unsigned fifo, uint32_t value) {
        if ((value & 1U << 4) != 0) overrun_[fifo] = false;
        if ((value & 1U << 5) == 0 || fifos_[fifo].empty()) return;
        releasing_[fifo] = true;
        if (!slow_release_) finish_release();
    }
    // CAN_MCR.RFLM = 0: the last one is overwritten (32.7.3).
    void store(unsigned fifo, const Message& message) {
        if (fifos_[fifo].size() < 3) return fifos_[fifo].push_back(message);
        overrun_[fifo] = true;
        fifos_[fifo].back() = message;
    }
    bool passes(uint32_t bank, uint32_t identifier) {
        const bool is_mask = (plain_[0x204] >> bank & 1) == 0 && (plain_[0x20C] >> bank & 1) != 0;
        const uint32_t wanted = plain_[0x240 + 8 * bank];
        return is_mask && ((identifier ^ wanted) & plain_[0x244 + 8 * bank]) == 0;
    }
    uint32_t error_status() const {
        const unsigned errors = transmit_errors_;
        return (errors >= 96 ? 1U : 0U) | (errors >= 128 ? 2U : 0U) | (bus_off_ ? 4U : 0U) |
               last_error_ << 4 | (errors & 0xFF) << 16;
    }
    uint32_t received(uint32_t place) const {
        const auto& fifo = fifos_[place / 16];
        if (fifo.empty()) return 0;
        const Message& message = fifo.front();
        const std::array<uint32_t, 4> words{message.identifier, message.length, message.words[0],
                                            message.words[1]};
        return words[place % 16 / 4];
    }
    void write_mailbox(uint32_t index, uint32_t place, uint32_t value) {
        Mailbox& mailbox = mailboxes_[index];
        if (mailbox.waits) {
            ++violations_;
        } else if (place == 0) {
            mailbox.message.identifier = value & ~1U;
            mailbox.waits = (value & 1) != 0;
            if (mailbox.waits) mailbox.status = 0;
        } else if (place == 4) {
            mailbox.message.length = value;
        } else {
            mailbox.message.words[(place - 8) / 4] = value;
        }
    }
    // 32.9.2 and 32.9.4: bit timing is written in initialisation, filters with FINIT.
    bool is_protected(uint32_t offset) {
        if (offset == 0x01C) return !initialising_;
        return offset > 0x200 && offset != 0x21C && (plain_[0x200] & 1) == 0;
    }

    // Registers that only keep what was written, with their values after reset.
    std::map<uint32_t, uint32_t> plain_{{0x000, 0x00010002}, {0x014, 0}, {0x200, 0x2A1C0E01}};
    std::array<Mailbox, kMailboxes> mailboxes_{};
    std::array<std::deque<Message>, 2> fifos_;
    std::array<bool, 2> overrun_{};
    std::array<bool, 2> releasing_{};
    unsigned sending_ = kNone;
    unsigned violations_ = 0;
    unsigned transmit_errors_ = 0;
    unsigned recessive_ = 0;
    uint32_t last_error_ = 0;
    bool sleeping_ = true;
    bool initialising_ = false;
    bool bus_off_ = false;
    bool may_recover_ = false;
    bool error_interrupt_ = false;
    bool answers_ = true;
    bool heeds_aborts_ = true;
    bool slow_release_ = false;
};

}  // namespace stator::testing
