/* Blobs: saved, opened in place and loaded, and refused whatever is wrong with them. */
#include "check.h"

/* Somewhere in memory that suits a blob. */
static unsigned char *aligned(unsigned char *memory) {
    return memory + (HD_BLOB_ALIGNMENT - (uintptr_t)memory % HD_BLOB_ALIGNMENT) % HD_BLOB_ALIGNMENT;
}

static void check_all(const hd_tree *tree) {
    for (uint32_t i = 0; i < COLUMNS; i++) {
        check_floor(tree, i, (7 * i) % COLUMNS, (int)(i % 2));
    }
}

static void fails_to_open(hd_status status, const unsigned char *bytes, size_t size) {
    hd_tree *tree = NULL;
    CHECK(hd_tree_open(bytes, size, &tree) == status);
    CHECK(tree == NULL && strlen(hd_last_error()) > 0);
    CHECK(hd_tree_load(bytes, size, &tree) == status);
    CHECK(tree == NULL);
}

int main(void) {
    hd_tree *made = floor_tree(HD_QUALITY_HIGH);
    size_t size = 0, again = 0;
    OK(hd_tree_save(made, NULL, 0, &size));
    unsigned char *memory = (unsigned char *)malloc(size + 2 * HD_BLOB_ALIGNMENT);
    unsigned char *blob = aligned(memory);
    FAILS(HD_ERROR_SIZE, "capacity", hd_tree_save(made, blob, size - 1, &again));
    FAILS(HD_ERROR_NULL, "bytes is NULL", hd_tree_save(made, NULL, size, &again));
    FAILS(HD_ERROR_NULL, "size is NULL", hd_tree_save(made, blob, size, NULL));
    FAILS(HD_ERROR_NULL, "size is NULL", hd_tree_save(made, NULL, 0, NULL));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_tree_save(NULL, blob, size, &again));
    CHECK(again == 0);
    OK(hd_tree_save(made, blob, size, &again));
    CHECK(again == size);

    hd_tree *opened = NULL, *loaded = NULL;
    OK(hd_tree_open(blob, size, &opened));
    check_all(opened);
    OK(hd_tree_load(blob, size, &loaded));
    check_all(loaded);
    hd_tree_free(loaded);

    /* One that was opened can be saved too. */
    unsigned char *copy = (unsigned char *)malloc(size + 1);
    OK(hd_tree_save(opened, copy, size, &again));
    CHECK(again == size && memcmp(copy, blob, size) == 0);
    hd_tree_free(opened);

    /* In place only where it can be traced; copied from anywhere. */
    memmove(copy + 1, copy, size);
    memmove(blob + 4, blob, size);
    FAILS(HD_ERROR_ALIGNMENT, "64", hd_tree_open(blob + 4, size, &opened));
    OK(hd_tree_load(blob + 4, size, &loaded));
    check_all(loaded);
    hd_tree_free(loaded);
    memmove(blob, blob + 4, size);

    FAILS(HD_ERROR_NULL, "bytes is NULL", hd_tree_open(NULL, size, &opened));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_tree_open(blob, size, NULL));
    FAILS(HD_ERROR_NULL, "bytes is NULL", hd_tree_load(NULL, size, &opened));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_tree_load(blob, size, NULL));
    fails_to_open(HD_ERROR_BLOB, blob, 0);
    fails_to_open(HD_ERROR_BLOB, blob, size - 1);
    fails_to_open(HD_ERROR_BLOB, (const unsigned char *)"a text, and no tree at all, however long it may be", 40);
    for (size_t length = 0; length < size; length += length < 200 ? 1 : 997) {
        fails_to_open(HD_ERROR_BLOB, blob, length);
    }
    for (size_t at = 0; at < size; at += at < 400 ? 1 : 211) {
        blob[at] ^= 0x10;
        hd_tree *tree = NULL;
        CHECK(hd_tree_open(blob, size, &tree) != HD_OK && tree == NULL);
        blob[at] ^= 0x10;
    }
    /* The version comes after eight bytes of magic and the mark of the bytes' order. */
    blob[12]++;
    fails_to_open(HD_ERROR_VERSION, blob, size);
    blob[12]--;

    /* After all that it is still the tree that it was. */
    OK(hd_tree_open(blob, size, &opened));
    check_all(opened);
    check_all(made);
    hd_tree_free(opened);
    hd_tree_free(made);
    free(copy);
    free(memory);
    puts("blobs: passed");
    return 0;
}
