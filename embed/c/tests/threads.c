/* Many threads trace one tree, and each has the message of its own mistakes. */
#include <pthread.h>

#include "check.h"

enum { THREADS = 4, TURNS = 300 };

struct task {
    const hd_tree *tree;
    int number;
};

static void *trace(void *argument) {
    const struct task *task = (const struct task *)argument;
    CHECK(strcmp(hd_last_error(), "") == 0);
    hd_ray ray = ray_of(0.5f, 0.5f, 1.0f, 0.0f, 0.0f, -1.0f);
    hd_hit hit;
    for (int turn = 0; turn < TURNS; turn++) {
        check_floor(task->tree, (uint32_t)((turn + task->number) % COLUMNS), (uint32_t)(turn % COLUMNS), turn % 2);
        if (task->number % 2) {
            CHECK(hd_intersect(task->tree, NULL, &hit) == HD_ERROR_NULL);
            CHECK(strcmp(hd_last_error(), "ray is NULL") == 0);
        } else {
            CHECK(hd_intersect(task->tree, &ray, NULL) == HD_ERROR_NULL);
            CHECK(strcmp(hd_last_error(), "hit is NULL") == 0);
        }
    }
    return NULL;
}

int main(void) {
    hd_tree *tree = floor_tree(HD_QUALITY_DEFAULT);
    struct task tasks[THREADS];
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++) {
        tasks[i].tree = tree;
        tasks[i].number = i;
        CHECK(pthread_create(&threads[i], NULL, trace, &tasks[i]) == 0);
    }
    for (int i = 0; i < THREADS; i++) {
        CHECK(pthread_join(threads[i], NULL) == 0);
    }
    CHECK(strcmp(hd_last_error(), "") == 0);
    hd_tree_free(tree);
    puts("threads: passed");
    return 0;
}
