# %% [markdown]
# **1.** By which share of its height was the slab pressed when it stopped? Reach **0.868**.

# %%
answer = 0.2 * history.time[-1]

# %% [markdown]
# **2.** A finer mesh fails earlier: it sees more of what the corners are strained by. By which
# share is a slab of 8 x 8 elements pressed? Change `mesh(4)` in `squash` to `mesh(8)`, and print
# the reason, which may be another (Newton's method stalls as cells are about to turn over): shorter
# steps stop there, too, so it is the load that is too much. Reach **0.797**.

# %%
four, mesh_of = mesh, mesh
mesh = lambda n: mesh_of(8)  # noqa: E731
fine = squash()
print(fine.reason)
answer = 0.2 * fine.time[-1]
mesh = four

# %% [markdown]
# **3.** Stop a run where something has happened: `run(until, dt, stop_when=...)` asks after each
# step. Drop the rigid block from rest on the floor, ask it to stop when the block moves upwards,
# and read the reason. Has it finished (1) or not (0)? Reach **0**.

# %%
contact = Contact(block, "base", floor)
run = Scene([block], [contact]).run(0.1, 0.01, stop_when=lambda: block.velocity[1] > 1e-6)
print(run.reason)
answer = int(run.finished)
