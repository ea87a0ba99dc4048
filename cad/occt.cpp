// SPDX-License-Identifier: Apache-2.0
#include "cad/occt.hpp"

#include <Message.hxx>
#include <Message_Messenger.hxx>

#ifdef __SANITIZE_ADDRESS__
/// Its registries, some kilobytes, live until the end of the program, and nobody frees them.
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libTK\n";
}
#endif

namespace cmm::cad {

std::unique_lock<std::mutex> alone_with_occt() {
    static std::mutex mutex;
    std::unique_lock lock(mutex);
    Message::DefaultMessenger()->ChangePrinters().Clear();
    return lock;
}

}  // namespace cmm::cad
