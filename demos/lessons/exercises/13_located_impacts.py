# %% [markdown]
# **1.** Which order has the error of the located impacts? Reach **2** (rounded).

# %%
answer = round(order["located"])

# %% [markdown]
# **2.** By the measured order, how many uniform steps to 0.24 s would the error of located impacts
# with `dt=0.005` need? Give the decimal logarithm, rounded: an error of first order is in
# proportion to the step. Reach **5**.

# %%
goal = rock(5e-3, locate_impacts=True)[0]
per_second = measured["uniform"][-1, 0] / steps["uniform"][-1]
answer = round(np.log10(0.24 / (goal / per_second)))

# %% [markdown]
# **3.** Let an error estimate choose the steps: `scene.run(until, dt, step_error=1e-5)`. How many
# tens of steps does it take to 0.24 s, rounded? Reach **13**.

# %%
mesh = mesh_from_gmsh("block.geo", width=0.36, height=0.80)
block = RigidSolid(mesh, mass=417.6, gravity=(0, -9.81), rotation=tilt, about=(-0.18, 0))
contact = Contact(block, "base", HalfSpace((0, 0), (0, 1)), friction=0.9)
scene = Scene([block], [contact], locate_impacts=True)
chosen = scene.run(until=0.24, dt=0.02, step_error=1e-5)
answer = round(chosen.steps / 10)
