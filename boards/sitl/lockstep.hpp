// A flight whose time goes on as another program says: docs/mavlink.md.
#pragma once

#include <string>

namespace stator::board {

// The other program listens at a Unix socket. It sends a byte for each step, and gets one once the
// step is flown and all that the vehicle sends by then is on its way. When it closes the
// connection, the flight goes on without it.
class Lockstep {
  public:
    Lockstep() = default;
    ~Lockstep() { close(); }
    Lockstep(const Lockstep&) = delete;
    Lockstep& operator=(const Lockstep&) = delete;

    // What is wrong; empty: nothing.
    std::string connect(const char* path);
    bool is_open() const { return socket_ >= 0; }
    // Until the next step is wanted, or a signal ends the flight.
    void wait();
    void tell_done();

  private:
    void close();

    int socket_ = -1;
};

}  // namespace stator::board
