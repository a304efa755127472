// A DMA controller: RM0090, chapter 10. Single items between a peripheral and memory; an item moves
// when its peripheral asks for it.
#pragma once

#include <vector>

#include "chip/block.hpp"

namespace stator::chip {

// A peripheral that DMA serves.
class DmaClient {
  public:
    DmaClient() = default;
    virtual ~DmaClient() = default;
    DmaClient(const DmaClient&) = delete;
    DmaClient& operator=(const DmaClient&) = delete;

    struct Request {
        unsigned controller, stream, channel;  // tables 42 and 43
        bool is_to_peripheral;
    };
    virtual std::span<const Request> requests() const = 0;
    virtual bool asks(bool is_to_peripheral) const = 0;
    virtual uint32_t data_address() const = 0;
};

class Dma : public Block {
  public:
    Dma(Chip& chip, unsigned controller);
    void connect(const DmaClient& client) { clients_.push_back(&client); }
    // Moves the most urgent item that is asked for. False: there is none.
    bool move_item();
    // The items that are left of the stream that serves the client; 0: none does.
    uint32_t items_left(const DmaClient& client, bool is_to_peripheral) const;

  private:
    uint32_t on_read(uint32_t offset) override;
    void on_write(uint32_t offset, uint32_t value) override;
    void control(unsigned stream, uint32_t value);
    void enable(unsigned stream, uint32_t value);
    bool asks(unsigned stream) const;
    const DmaClient* client_of(unsigned stream) const;
    void transfer(unsigned stream);
    void copy(unsigned stream);
    const uint8_t* fetch(unsigned stream, uint32_t memory, uint32_t width);
    void raise(unsigned stream, uint32_t flags);
    void update(unsigned stream);
    uint32_t flags_of(unsigned stream) const;
    uint32_t stream_at(unsigned stream, uint32_t offset) const;

    static constexpr uint32_t kAhead = 64;
    struct Stream {
        uint32_t items = 0;  // as it was enabled
        uint32_t moved = 0;
        // Fetched before their turn.
        std::array<uint8_t, kAhead> ahead{};
        uint32_t ahead_from = 0;
        uint32_t ahead_bytes = 0;
    };
    unsigned controller_;
    Stream streams_[8];
    std::vector<const DmaClient*> clients_;
};

}  // namespace stator::chip
