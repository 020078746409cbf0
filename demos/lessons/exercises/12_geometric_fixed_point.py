# %% [markdown]
# **1.** Put a plane in place of the drum, `HalfSpace((0, 0), (0, 1))`. How many rounds does the
# fixed point take now? Reach **1**.

# %%
from fenicsx_contact import HalfSpace

answer = len(press(1.0, "fixed point", HalfSpace((0, 0), (0, 1)))[0])

# %% [markdown]
# **2.** A drum of radius 0.3: how many rounds? Reach **15**.

# %%
answer = len(press(0.3, "fixed point")[0])

# %% [markdown]
# **3.** In Newton's method the exponent of the error doubles, near the end. Which order do the last
# three residuals on the drum of radius 1 show, by $\log(e_3/e_2)/\log(e_2/e_1)$, rounded? Reach
# **2**.

# %%
late = np.log(together[1.0][0][-4:-1])
answer = round(np.diff(late)[1] / np.diff(late)[0])
