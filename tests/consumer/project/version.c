/* Prints the version of the linked library. */
#include <stdio.h>

#include <stratus/stratus.h>

int main(void) {
    printf("%s\n", stratus_version());
    return stratus_abi_version() != STRATUS_ABI_VERSION;
}
