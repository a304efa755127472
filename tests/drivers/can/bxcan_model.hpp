// The registers of bxCAN as RM0090, chapter 32 describes them: what a driver sees of mailboxes,
// FIFOs, filters, initialisation and errors. No bits and no time; the test says when something
// happens.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "bxcan_port.hpp"

namespace stator::testing {

class BxcanModel {
  public:
    struct Message {
        uint32_t identifier = 0;  // as CAN_TIxR, without the request
        uint32_t length = 0;
        std::array<uint32_t, 2> words{};
    };

    uint32_t read(uint32_t offset) {
        using namespace bxcan;
        if (offset == kMasterStatus) return initialising_ ? kInitAcknowledge : 0;
        if (offset == kTransmitStatus) return transmit_status();
        if (offset == kFifo || offset == kFifo + 4) return fifo_status((offset - kFifo) / 4);
        if (offset == kErrorStatus) return errors_;
        if (offset >= kReceiveMailbox && offset < kReceiveMailbox + 32) return received(offset);
        return plain_[offset];
    }
    void write(uint32_t offset, uint32_t value) {
        using namespace bxcan;
        if (offset == kMasterControl) {
            if ((value & kInitRequest) == 0 && wants_init_ && (errors_ & kBusOff) != 0) errors_ = 0;
            wants_init_ = (value & kInitRequest) != 0;
            if (answers_) initialising_ = wants_init_;
            if (initialising_) mailboxes_ = {};
        } else if (offset == kTransmitStatus) {
            completed_ &= ~value;  // written ones clear
        } else if (offset == kFifo || offset == kFifo + 4) {
            write_fifo((offset - kFifo) / 4, value);
        } else if (offset >= kTransmitMailbox && offset < kTransmitMailbox + 48) {
            write_mailbox((offset - kTransmitMailbox) / 16, (offset - kTransmitMailbox) % 16,
                          value);
        } else {
            plain_[offset] = value;
        }
    }

    // The bus takes a frame: the lowest identifier that waits, of equal ones the lowest mailbox.
    std::optional<Message> transmit() {
        unsigned best = bxcan::kMailboxes;
        for (unsigned i = bxcan::kMailboxes; i > 0; --i) {
            const bool waits = mailboxes_[i - 1].waits;
            if (waits && (best == bxcan::kMailboxes || mailboxes_[i - 1].message.identifier <=
                                                           mailboxes_[best].message.identifier)) {
                best = i - 1;
            }
        }
        if (best == bxcan::kMailboxes) return std::nullopt;
        mailboxes_[best].waits = false;
        completed_ |= (bxcan::kRequestCompleted | bxcan::kTransmitOk) << (8 * best);
        return mailboxes_[best].message;
    }
    // A frame on the bus: to the FIFO of the first bank that lets it pass.
    void receive(const Message& message) {
        using namespace bxcan;
        for (uint32_t bank = 0; bank < 28; ++bank) {
            if (((plain_[kFilterActive] >> bank) & 1) == 0) continue;
            const uint32_t wanted = plain_[kFilterBank + 8 * bank];
            const uint32_t mask = plain_[kFilterBank + 8 * bank + 4];
            if (((message.identifier ^ wanted) & mask) != 0) continue;
            const unsigned fifo = (plain_[kFilterFifo] >> bank) & 1;
            if (fifos_[fifo].size() < 3) {
                fifos_[fifo].push_back(message);
            } else {
                overrun_[fifo] = true;
                fifos_[fifo].back() = message;  // the last one is overwritten: CAN_MCR.RFLM = 0
            }
            return;
        }
    }
    void set_errors(uint32_t status) { errors_ = status; }
    void set_answering(bool answers) { answers_ = answers; }
    uint32_t plain(uint32_t offset) { return plain_[offset]; }
    unsigned waiting() const {
        unsigned count = 0;
        for (const auto& mailbox : mailboxes_) count += mailbox.waits ? 1 : 0;
        return count;
    }

  private:
    struct Mailbox {
        Message message{};
        bool waits = false;
    };

    uint32_t transmit_status() const {
        uint32_t status = completed_;
        for (unsigned i = 0; i < bxcan::kMailboxes; ++i) {
            if (!mailboxes_[i].waits) status |= bxcan::kFirstEmpty << i;
        }
        return status;
    }
    uint32_t fifo_status(unsigned fifo) const {
        return static_cast<uint32_t>(fifos_[fifo].size()) |
               (overrun_[fifo] ? bxcan::kFifoOverrun : 0);
    }
    void write_fifo(unsigned fifo, uint32_t value) {
        if ((value & bxcan::kFifoOverrun) != 0) overrun_[fifo] = false;
        if ((value & bxcan::kFifoRelease) != 0 && !fifos_[fifo].empty()) fifos_[fifo].pop_front();
    }
    uint32_t received(uint32_t offset) const {
        const uint32_t place = offset - bxcan::kReceiveMailbox;
        const auto& fifo = fifos_[place / 16];
        if (fifo.empty()) return 0;
        const Message& message = fifo.front();
        const std::array<uint32_t, 4> words{message.identifier, message.length, message.words[0],
                                            message.words[1]};
        return words[place % 16 / 4];
    }
    void write_mailbox(uint32_t mailbox, uint32_t place, uint32_t value) {
        Message& message = mailboxes_[mailbox].message;
        if (place == 0) {
            message.identifier = value & ~bxcan::kTransmitRequest;
            mailboxes_[mailbox].waits = (value & bxcan::kTransmitRequest) != 0;
        } else if (place == 4) {
            message.length = value;
        } else {
            message.words[(place - 8) / 4] = value;
        }
    }

    std::map<uint32_t, uint32_t> plain_;  // registers that only keep what was written
    std::array<Mailbox, bxcan::kMailboxes> mailboxes_{};
    std::array<std::deque<Message>, 2> fifos_;
    std::array<bool, 2> overrun_{};
    uint32_t completed_ = 0;
    uint32_t errors_ = 0;
    bool wants_init_ = false;
    bool initialising_ = false;
    bool answers_ = true;
};

}  // namespace stator::testing
