// The machine: a request to restart is handed to the board.
#include "system_board.hpp"

namespace stator::drivers::system::board {

void SystemBoard::step(SystemPorts& ports) {
    if (ports.restart.is_new() && !is_asked_) {
        is_asked_ = true;
        asked_us_ = ports.now;
    }
    const bool is_disarmed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kDisarmed;
    if (!is_disarmed) is_asked_ = false;
    if (!is_asked_ || ports.now - asked_us_ < kAnswerTime_us) return;
    is_asked_ = false;
    if (device_.restart == nullptr) return;
    device_.restarts = true;
    device_.restart();
}

}  // namespace stator::drivers::system::board
