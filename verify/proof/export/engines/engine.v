Require Import ZArith QArith List Field InitialRing Lia.
Import ListNotations.

(* Polynomials over the rationals: C c is a constant, H i p q is p + g_i * q. *)
Inductive poly := C (c : Q) | H (i : positive) (p q : poly).

Definition qadd (a b : Q) : Q :=
  match a, b with
  | x # 1, y # 1 => (x + y) # 1
  | _, _ => Qred (a + b)
  end.
Definition qmul (a b : Q) : Q :=
  match a, b with
  | x # 1, y # 1 => (x * y) # 1
  | _, _ => Qred (a * b)
  end.
Definition is_zero (p : poly) : bool :=
  match p with C c => Z.eqb (Qnum c) 0 | _ => false end.
Definition mk (i : positive) (p q : poly) : poly := if is_zero q then p else H i p q.
Fixpoint addc (x : Q) (b : poly) : poly :=
  match b with C y => C (qadd x y) | H j r s => H j (addc x r) s end.
Fixpoint padd (a : poly) : poly -> poly :=
  match a with
  | C x => addc x
  | H i p q => fix aux (b : poly) : poly :=
      match b with
      | C y => H i (addc y p) q
      | H j r s =>
          match Pos.compare i j with
          | Eq => mk i (padd p r) (padd q s)
          | Gt => H i (padd p b) q
          | Lt => H j (aux r) s
          end
      end
  end.
Fixpoint scal (c : Q) (p : poly) : poly :=
  match p with C x => C (qmul c x) | H i p q => mk i (scal c p) (scal c q) end.
Definition popp : poly -> poly := scal (-1 # 1).
Fixpoint pmul (a : poly) : poly -> poly :=
  match a with
  | C x => scal x
  | H i p q => fix aux (b : poly) : poly :=
      match b with
      | C y => scal y a
      | H j r s =>
          match Pos.compare i j with
          | Eq => mk i (pmul p r) (padd (pmul p s) (pmul q b))
          | Gt => mk i (pmul p b) (pmul q b)
          | Lt => mk j (aux r) (aux s)
          end
      end
  end.
Fixpoint ppow (p : poly) (n : nat) : poly :=
  match n with O => C 1 | S n => pmul p (ppow p n) end.

(* A rule (i, k, v) says that g_i ^ (k + 1) is v. *)
Definition rule := (positive * nat * poly)%type.
Fixpoint split (i : positive) (k : nat) (q : poly) : poly * poly :=
  match k with
  | O => (C 0, q)
  | S k => match q with
           | H j p r => if Pos.eqb j i
                        then let (l, c) := split i k r in (mk i p l, c)
                        else (q, C 0)
           | C _ => (q, C 0)
           end
  end.
Fixpoint lower (r : rule) (p : poly) : poly :=
  match p with
  | C _ => p
  | H j a b =>
      let '(i, k, v) := r in
      match Pos.compare j i with
      | Eq => let (l, c) := split i k (lower r b) in padd (mk i a l) (pmul v c)
      | Gt => padd (lower r a) (pmul (H j (C 0) (C 1)) (lower r b))
      | Lt => p
      end
  end.
Definition nf (rs : list rule) (p : poly) : poly := fold_left (fun p r => lower r p) rs p.

(* A value (N, e) is N over the product of the denominators to the powers e. *)
Definition frac := (poly * list nat)%type.
Fixpoint emax (a b : list nat) : list nat :=
  match a, b with
  | [], _ => b
  | _, [] => a
  | x :: a, y :: b => Nat.max x y :: emax a b
  end.
Fixpoint esub (a b : list nat) : list nat :=
  match a, b with
  | [], _ => []
  | _, [] => a
  | x :: a, y :: b => (x - y)%nat :: esub a b
  end.
Fixpoint eadd (a b : list nat) : list nat :=
  match a, b with
  | [], _ => b
  | _, [] => a
  | x :: a, y :: b => (x + y)%nat :: eadd a b
  end.
Fixpoint below (e : list nat) (fs : list poly) : poly :=
  match e, fs with
  | O :: e, _ :: fs => below e fs
  | n :: e, f :: fs => pmul (ppow f n) (below e fs)
  | _, _ => C 1
  end.

(* Division of polynomials; what it finds is multiplied out before it is used. *)
Fixpoint degree (i : positive) (p : poly) : nat :=
  match p with
  | H j _ q => if Pos.eqb j i then S (degree i q) else O
  | C _ => O
  end.
Fixpoint lead (i : positive) (p : poly) : poly :=
  match p with
  | H j _ q => if Pos.eqb j i then lead i q else p
  | C _ => p
  end.
Fixpoint shift (i : positive) (n : nat) (p : poly) : poly :=
  match n with O => p | S n => mk i (C 0) (shift i n p) end.
Fixpoint quotient (fuel : nat) (a b : poly) : option poly :=
  if is_zero a then Some (C 0) else
  match fuel with
  | O => None
  | S fuel =>
      match a, b with
      | _, C c => if Z.eqb (Qnum c) 0 then None else Some (scal (Qred (/ c)) a)
      | C _, _ => None
      | H i p q, H j _ _ =>
          match Pos.compare i j with
          | Lt => None
          | Gt => match quotient fuel p b, quotient fuel q b with
                  | Some p, Some q => Some (mk i p q)
                  | _, _ => None
                  end
          | Eq =>
              let (m, n) := (degree i a, degree i b) in
              if Nat.ltb m n then None else
              match quotient fuel (lead i a) (lead i b) with
              | None => None
              | Some t =>
                  let t := shift i (m - n) t in
                  match quotient fuel (padd a (popp (pmul t b))) b with
                  | None => None
                  | Some s => Some (padd t s)
                  end
              end
          end
      end
  end.
Fixpoint strip (fuel : nat) (keep have : nat) (p f : poly) : poly * nat :=
  match fuel with
  | O => (p, have)
  | S fuel =>
      if Nat.leb have keep then (p, have) else
      match quotient 400 p f with
      | Some q => strip fuel keep (have - 1) q f
      | None => (p, have)
      end
  end.
Fixpoint strips (p : poly) (have keep : list nat) (fs : list poly) : poly * list nat :=
  match have, fs with
  | h :: have, f :: fs =>
      let (p, n) := strip 100 (hd O keep) h p f in
      let (p, e) := strips p have (tl keep) fs in (p, n :: e)
  | _, _ => (p, have)
  end.
Fixpoint factored (p : poly) (fs : list poly) : poly * list nat :=
  match fs with
  | [] => (p, [])
  | f :: fs =>
      let (p, n) := strip 100 0 100 p f in
      let (p, e) := factored p fs in (p, (100 - n)%nat :: e)
  end.

Section Values.
Variables (fs : list poly) (rs : list rule).

Definition constant (c : Q) : frac := (C c, []).
Definition fadd (a b : frac) : frac :=
  let (n, e) := a in let (m, d) := b in
  if is_zero n then b else if is_zero m then a else
  let t := emax e d in
  (nf rs (padd (pmul n (below (esub t e) fs)) (pmul m (below (esub t d) fs))), t).
Definition fmul (a b : frac) : frac :=
  let (n, e) := a in let (m, d) := b in (nf rs (pmul n m), eadd e d).
Definition fopp (a : frac) : frac := (popp (fst a), snd a).
Fixpoint fpow (a : frac) (n : nat) : frac :=
  match n with O => constant 1 | S O => a | S n => fmul a (fpow a n) end.
Definition same (a b : frac) : bool := is_zero (fst (fadd a (fopp b))).
Definition cut (a : frac) (keep : list nat) : frac :=
  let b := strips (fst a) (snd a) keep fs in
  if same a b then b else a.
(* An inverse is guessed, the root g_i in it as g_i^k over its power, and multiplied out. *)
Fixpoint find_rule (f : poly) (rs : list rule) : option rule :=
  match rs, f with
  | (i, k, v) :: rs, H j p (C _) =>
      if andb (Pos.eqb i j) (is_zero p) then Some (i, k, v) else find_rule f rs
  | _, _ => None
  end.
Fixpoint inverse (fuel : nat) (n : poly) : frac :=
  match fuel with
  | O => constant 0
  | S fuel =>
      let (c, e) := factored n fs in
      let start := match c with C c => (C (Qred (/ c)), []) | _ => constant 0 end in
      (fix go (e : list nat) (gs : list poly) (before : list nat) (s : frac) : frac :=
         match e, gs with
         | O :: e, _ :: gs => go e gs (O :: before) s
         | n :: e, f :: gs =>
             let t := match find_rule f rs with
                      | Some (i, k, v) => fpow (fmul (ppow f k, []) (inverse fuel v)) n
                      | None => (C 1, rev (n :: before))
                      end in
             go e gs (O :: before) (fmul s t)
         | _, _ => s
         end) e fs [] start
  end.
Definition finv (a : frac) : option frac :=
  let b := fmul (below (snd a) fs, []) (inverse 8 (fst a)) in
  if same (fmul a b) (constant 1) then Some b else None.

(* The derivative of a polynomial: factors of the derivatives of generators. *)
Fixpoint insert (i : positive) (c : poly) (l : list (positive * poly)) : list (positive * poly) :=
  match l with
  | [] => [(i, c)]
  | (j, d) :: l => if Pos.eqb i j then (j, padd c d) :: l else (j, d) :: insert i c l
  end.
Definition merge (a b : list (positive * poly)) : list (positive * poly) :=
  fold_right (fun x l => insert (fst x) (snd x) l) b a.
Fixpoint partials (p : poly) : list (positive * poly) :=
  match p with
  | C _ => []
  | H i p q =>
      merge (map (fun x => (fst x, mk i (C 0) (snd x))) (partials q)) (insert i q (partials p))
  end.
Definition slopes := list (nat * positive * frac).
Fixpoint find (v : nat) (i : positive) (l : slopes) : option frac :=
  match l with
  | [] => None
  | (w, j, f) :: l => if andb (Nat.eqb v w) (Pos.eqb i j) then Some f else find v i l
  end.
Variable sl : slopes.
Fixpoint dsum (v : nat) (l : list (positive * poly)) : option frac :=
  match l with
  | [] => Some (constant 0)
  | (i, c) :: l =>
      match find v i sl, dsum v l with
      | Some s, Some t => Some (fadd (fmul (c, []) s) t)
      | _, _ => None
      end
  end.
Definition dpoly (v : nat) (p : poly) : option frac := dsum v (partials p).
Fixpoint dlog (v : nat) (e : list nat) (gs : list poly) : option frac :=
  match e, gs with
  | O :: e, _ :: gs => dlog v e gs
  | n :: e, f :: gs =>
      match dpoly v f, dlog v e gs, finv (f, []) with
      | Some d, Some t, Some u =>
          Some (fadd (fmul (constant (Z.of_nat n # 1)) (cut (fmul d u) [])) t)
      | _, _, _ => None
      end
  | _, _ => Some (constant 0)
  end.
Definition dfrac (v : nat) (a : frac) : option frac :=
  match dpoly v (fst a), dlog v (snd a) fs with
  | Some d, Some t => Some (fadd (fmul d (C 1, snd a)) (fopp (fmul a t)))
  | _, _ => None
  end.
End Values.

(* What a script says. *)
Inductive ex :=
  | Num (q : Q) | Gen (i : positive) | Nam (i : positive)
  | Sum (a b : ex) | Prod (a b : ex) | Neg (a : ex) | Inv (a : ex) | Pow (a : ex) (n : nat)
  | Der (v : nat) (a : ex).
Inductive step :=
  | Def (k : positive) (e : ex) (keep : option (list nat))  (* name k is e *)
  | Rel (i : positive) (k : nat) (e : ex)                  (* g_i ^ (k + 1) is e *)
  | Slo (v : nat) (i : positive) (e : ex) (keep : option (list nat))  (* that of g_i is e *)
  | Rat (v : nat) (k : positive) (e : ex) (keep : option (list nat))  (* that of name k: to be shown *)
  | Zer (e : ex).                                          (* e is 0: to be shown *)
Record state := State {
  names : list (nat * positive * frac); rels : list rule;
  gens : slopes; rates : slopes }.

Section Run.
Variable fs : list poly.
Fixpoint eval (s : state) (e : ex) : option frac :=
  match e with
  | Num q => Some (constant q)
  | Gen i => Some (H i (C 0) (C 1), [])
  | Nam k => find 0 k (names s)
  | Sum a b => match eval s a, eval s b with
               | Some a, Some b => Some (fadd fs (rels s) a b) | _, _ => None end
  | Prod a b => match eval s a, eval s b with
               | Some a, Some b => Some (fmul (rels s) a b) | _, _ => None end
  | Neg a => match eval s a with Some a => Some (fopp a) | _ => None end
  | Inv a => match eval s a with Some a => finv fs (rels s) a | _ => None end
  | Pow a n => match eval s a with Some a => Some (fpow (rels s) a n) | _ => None end
  | Der v a =>
      match match a with Nam k => find v k (rates s) | _ => None end with
      | Some f => Some f
      | None => match eval s a with Some a => dfrac fs (rels s) (gens s) v a | _ => None end
      end
  end.
Definition value (s : state) (e : ex) (keep : option (list nat)) : option frac :=
  match eval s e, keep with
  | Some a, Some keep => Some (cut fs (rels s) a keep)
  | Some a, None => Some a
  | None, _ => None
  end.
Definition advance (s : state) (t : step) : option state :=
  match t with
  | Def k e keep =>
      match value s e keep with
      | Some a => Some (State ((O, k, a) :: names s) (rels s) (gens s) (rates s))
      | None => None
      end
  | Rel i k e =>
      match value s e (Some []) with
      | Some (n, d) =>
          if forallb (Nat.eqb 0) d
          then Some (State (names s) ((i, k, n) :: rels s) (gens s) (rates s)) else None
      | None => None
      end
  | Slo v i e keep =>
      match value s e keep with
      | Some a => Some (State (names s) (rels s) ((v, i, a) :: gens s) (rates s))
      | None => None
      end
  | Rat v k e keep =>
      match eval s (Der v (Nam k)), value s e keep with
      | Some a, Some b =>
          if same fs (rels s) a b
          then Some (State (names s) (rels s) (gens s) ((v, k, b) :: rates s)) else None
      | _, _ => None
      end
  | Zer e =>
      match eval s e with
      | Some (n, _) => if is_zero n then Some s else None
      | None => None
      end
  end.
Fixpoint run (s : state) (l : list step) : option state :=
  match l with
  | [] => Some s
  | t :: l => match advance s t with Some s => run s l | None => None end
  end.
End Run.
Definition start : state := State [] [] [] [].
Fixpoint polynomials (ds : list ex) : option (list poly) :=
  match ds with
  | [] => Some []
  | d :: ds =>
      match eval [] start d, polynomials ds with
      | Some (p, _), Some fs => Some (p :: fs)
      | _, _ => None
      end
  end.
Definition accepts (ds : list ex) (l : list step) : bool :=
  match polynomials ds with
  | Some fs => match run fs start l with Some _ => true | None => false end
  | None => false
  end.

Lemma some_inj (A : Type) (x y : A) : Some x = Some y -> x = y.
Proof. congruence. Qed.

Section Soundness.
Variables (F : Type) (f0 f1 : F) (fadd' fmul' fsub' : F -> F -> F) (fopp' : F -> F)
  (fdiv' : F -> F -> F) (finv' : F -> F).
Hypothesis field_F : field_theory f0 f1 fadd' fmul' fsub' fopp' fdiv' finv' eq.
Add Field ff : field_F.
Declare Scope f_scope. Delimit Scope f_scope with f.
Notation "0" := f0 : f_scope.
Notation "1" := f1 : f_scope.
Infix "+" := fadd' : f_scope.
Infix "*" := fmul' : f_scope.
Infix "-" := fsub' : f_scope.
Notation "- x" := (fopp' x) : f_scope.
Notation "/ x" := (finv' x) : f_scope.
Definition integer : Z -> F := gen_phiZ f0 f1 fadd' fmul' fopp'.
Hypothesis characteristic_0 : forall p, integer (Zpos p) <> f0.
Variable D : nat -> F -> F.
Hypothesis D_sum : forall v a b, D v (a + b)%f = (D v a + D v b)%f.
Hypothesis D_product : forall v a b, D v (a * b)%f = (D v a * b + a * D v b)%f.
Local Open Scope f_scope.

Lemma integer_morph : ring_morph f0 f1 fadd' fmul' fsub' fopp' eq
  0%Z 1%Z Z.add Z.mul Z.sub Z.opp Zeq_bool integer.
Proof.
  apply gen_phiZ_morph; [apply Eqsth | apply Eq_ext | exact (F_R field_F)].
Qed.
Lemma integer_add a b : integer (a + b) = integer a + integer b.
Proof. apply (morph_add integer_morph). Qed.
Lemma integer_mul a b : integer (a * b) = integer a * integer b.
Proof. apply (morph_mul integer_morph). Qed.

Definition number (q : Q) : F := integer (Qnum q) * / integer (Zpos (Qden q)).
Lemma number_eq a b : (a == b)%Q -> number a = number b.
Proof.
  unfold Qeq, number; intro E. apply (f_equal integer) in E. rewrite !integer_mul in E.
  pose proof (characteristic_0 (Qden a)). pose proof (characteristic_0 (Qden b)).
  transitivity (integer (Qnum a) * integer (Zpos (Qden b))
                * (/ integer (Zpos (Qden a)) * / integer (Zpos (Qden b)))).
  - field; auto.
  - rewrite E; field; auto.
Qed.
Lemma number_qplus a b : number (a + b)%Q = number a + number b.
Proof.
  unfold number, Qplus; cbn [Qnum Qden]. rewrite integer_add, Pos2Z.inj_mul, !integer_mul.
  field; split; apply characteristic_0.
Qed.
Lemma number_qmult a b : number (a * b)%Q = number a * number b.
Proof.
  unfold number, Qmult; cbn [Qnum Qden]. rewrite Pos2Z.inj_mul, !integer_mul.
  field; split; apply characteristic_0.
Qed.
Lemma qadd_ok a b : number (qadd a b) = number a + number b.
Proof.
  rewrite <- number_qplus. apply number_eq.
  destruct a as [x p], b as [y q]; unfold qadd.
  destruct p, q; try apply Qred_correct; unfold Qplus, Qeq; simpl; lia.
Qed.
Lemma qmul_ok a b : number (qmul a b) = number a * number b.
Proof.
  rewrite <- number_qmult. apply number_eq.
  destruct a as [x p], b as [y q]; unfold qmul.
  destruct p, q; try apply Qred_correct; unfold Qmult, Qeq; simpl; lia.
Qed.
Lemma number_0 n : Qnum n = 0%Z -> number n = 0.
Proof. unfold number; intros ->. change (integer 0) with f0. field. apply characteristic_0. Qed.
Lemma number_1 : number 1 = 1.
Proof. unfold number; simpl. change (integer 1) with f1. field. apply (characteristic_0 1). Qed.
Lemma number_m1 : number (-1 # 1) = - (1).
Proof. unfold number; simpl. change (integer 1) with f1. field. apply (characteristic_0 1). Qed.

Section Meaning.
Variable g : positive -> F.
Fixpoint ev (p : poly) : F :=
  match p with C c => number c | H i p q => ev p + g i * ev q end.

Lemma is_zero_ok p : is_zero p = true -> ev p = 0.
Proof. destruct p; simpl; [|discriminate]. intro E; apply number_0, Z.eqb_eq, E. Qed.
Lemma mk_ok i p q : ev (mk i p q) = ev p + g i * ev q.
Proof.
  unfold mk; destruct (is_zero q) eqn:E; [|reflexivity]. rewrite (is_zero_ok _ E); ring.
Qed.
Lemma addc_ok x b : ev (addc x b) = number x + ev b.
Proof. induction b; simpl; [apply qadd_ok|]. rewrite IHb1; ring. Qed.
Lemma padd_ok a : forall b, ev (padd a b) = ev a + ev b.
Proof.
  induction a as [x | i p IHp q IHq]; intro b; [apply addc_ok|].
  induction b as [y | j r IHr s IHs]; [simpl; rewrite addc_ok; ring|].
  cbn [padd]. destruct (Pos.compare i j) eqn:E.
  - apply Pos.compare_eq in E; subst. rewrite mk_ok, IHp, IHq; simpl; ring.
  - cbn [padd] in IHr. simpl ev. rewrite IHr; simpl; ring.
  - simpl ev. rewrite IHp; simpl; ring.
Qed.
Lemma scal_ok c p : ev (scal c p) = number c * ev p.
Proof. induction p; simpl; [apply qmul_ok|]. rewrite mk_ok, IHp1, IHp2; ring. Qed.
Lemma popp_ok p : ev (popp p) = - ev p.
Proof. unfold popp. rewrite scal_ok, number_m1; ring. Qed.
Lemma pmul_ok a : forall b, ev (pmul a b) = ev a * ev b.
Proof.
  induction a as [x | i p IHp q IHq]; intro b; [apply scal_ok|].
  induction b as [y | j r IHr s IHs]; [cbn [pmul]; rewrite scal_ok; simpl; ring|].
  cbn [pmul]. destruct (Pos.compare i j) eqn:E.
  - apply Pos.compare_eq in E; subst. rewrite mk_ok, padd_ok, !IHp, IHq; simpl; ring.
  - cbn [pmul] in IHr, IHs. rewrite mk_ok, IHr, IHs; simpl; ring.
  - rewrite mk_ok, IHp, IHq; simpl; ring.
Qed.
Fixpoint power (x : F) (n : nat) : F := match n with O => 1 | S n => x * power x n end.
Lemma power_add x n m : power x (n + m) = power x n * power x m.
Proof. induction n; simpl; [ring|]. rewrite IHn; ring. Qed.
Lemma ppow_ok p n : ev (ppow p n) = power (ev p) n.
Proof. induction n; simpl; [apply number_1|]. rewrite pmul_ok, IHn; reflexivity. Qed.
Lemma number_00 : number 0 = 0.
Proof. apply number_0; reflexivity. Qed.

Definition holds (r : rule) : Prop :=
  let '(i, k, v) := r in power (g i) (S k) = ev v.
Lemma split_ok i k : forall q l c, split i k q = (l, c) -> ev q = ev l + power (g i) k * ev c.
Proof.
  induction k; intros q l c E; simpl in E.
  - inversion E; subst; simpl. rewrite number_00; ring.
  - destruct q as [x | j p r].
    + inversion E; subst; simpl; rewrite number_00; ring.
    + destruct (Pos.eqb_spec j i).
      * destruct (split i k r) as [l' c'] eqn:E'. inversion E; subst.
        rewrite mk_ok; simpl. rewrite (IHk _ _ _ E'); ring.
      * inversion E; subst; simpl; rewrite number_00; ring.
Qed.
Lemma lower_ok r p : holds r -> ev (lower r p) = ev p.
Proof.
  destruct r as [[i k] v]; intro R. induction p as [x | j a IHa b IHb]; [reflexivity|].
  cbn [lower]. destruct (Pos.compare j i) eqn:E.
  - apply Pos.compare_eq in E; subst.
    destruct (split i k (lower (i, k, v) b)) as [l c] eqn:S.
    apply split_ok in S. rewrite padd_ok, mk_ok, pmul_ok. simpl ev. rewrite <- IHb, S.
    simpl in R. rewrite <- R; ring.
  - reflexivity.
  - rewrite padd_ok, pmul_ok, IHa, IHb. simpl. rewrite number_00, number_1; ring.
Qed.
Lemma nf_ok rs : Forall holds rs -> forall p, ev (nf rs p) = ev p.
Proof.
  unfold nf; induction 1; intro p; simpl; [reflexivity|]. rewrite IHForall. now apply lower_ok.
Qed.

Section Fractions.
Variable fs : list poly.
Hypothesis not_zero : Forall (fun f => ev f <> 0) fs.
Fixpoint pw (e : list nat) (fs : list poly) : F :=
  match e, fs with n :: e, f :: fs => power (ev f) n * pw e fs | _, _ => 1 end.
Definition value_of (a : frac) : F := ev (fst a) * / pw (snd a) fs.

Lemma power_nz x n : x <> 0 -> power x n <> 0.
Proof.
  intro X; induction n; simpl.
  - apply (F_1_neq_0 field_F).
  - intro E. apply IHn. transitivity (/ x * (x * power x n)); [field; auto|]. rewrite E; ring.
Qed.
Lemma product_nz a b : a <> 0 -> b <> 0 -> a * b <> 0.
Proof.
  intros A B E. apply B. transitivity (/ a * (a * b)); [field; auto|]. rewrite E; ring.
Qed.
Lemma pw_all_nz l : Forall (fun f => ev f <> 0) l -> forall e, pw e l <> 0.
Proof.
  induction 1 as [|f l Hf Hl IH]; intros [|n e]; simpl; try apply (F_1_neq_0 field_F).
  apply product_nz; [now apply power_nz | apply IH].
Qed.
Lemma pw_nz e : pw e fs <> 0.
Proof. now apply pw_all_nz. Qed.
Lemma below_ok e : forall fs, ev (below e fs) = pw e fs.
Proof.
  induction e as [|n e IH]; intros [|f l]; try apply number_1.
  - destruct n; apply number_1.
  - destruct n; cbn [below]; [rewrite IH; simpl; ring|].
    rewrite pmul_ok, ppow_ok, IH; reflexivity.
Qed.
Lemma esub_self e : forall l, pw (esub e e) l = 1.
Proof.
  induction e as [|n e IH]; intros [|f l]; simpl; try reflexivity.
  rewrite IH, Nat.sub_diag; simpl; ring.
Qed.
Lemma emax_l e : forall d fs, pw (emax e d) fs = pw (esub (emax e d) e) fs * pw e fs.
Proof.
  induction e as [|n e IH]; intros d l.
  - simpl. destruct d; simpl; destruct l; ring.
  - destruct d as [|m d]; destruct l as [|f l]; simpl; try ring.
    + replace (n - n)%nat with O by lia.
      rewrite esub_self; simpl; ring.
    + rewrite (IH d l). replace (power (ev f) (Nat.max n m))
        with (power (ev f) (Nat.max n m - n) * power (ev f) n)
        by (rewrite <- power_add; f_equal; lia). ring.
Qed.
Lemma emax_comm e : forall d, emax e d = emax d e.
Proof. induction e; intros [|m d]; simpl; auto. rewrite Nat.max_comm, IHe; reflexivity. Qed.
Lemma emax_r e d l : pw (emax e d) l = pw (esub (emax e d) d) l * pw d l.
Proof. rewrite emax_comm; apply emax_l. Qed.
Lemma eadd_ok e : forall d fs, pw (eadd e d) fs = pw e fs * pw d fs.
Proof.
  induction e as [|n e IH]; intros d l; simpl; [destruct d; simpl; destruct l; ring|].
  destruct d as [|m d]; destruct l as [|f l]; simpl; try ring.
  rewrite IH, power_add; ring.
Qed.

Section Rules.
Variable rs : list rule.
Hypothesis rs_hold : Forall holds rs.

Lemma constant_ok c : value_of (constant c) = number c.
Proof. unfold value_of, constant; simpl. field. apply (F_1_neq_0 field_F). Qed.
Lemma fadd_ok a b : value_of (fadd fs rs a b) = value_of a + value_of b.
Proof.
  destruct a as [n e], b as [m d]; unfold fadd.
  destruct (is_zero n) eqn:N; [unfold value_of; simpl; rewrite (is_zero_ok _ N); ring|].
  destruct (is_zero m) eqn:M; [unfold value_of; simpl; rewrite (is_zero_ok _ M); ring|].
  unfold value_of; cbn [fst snd]. rewrite nf_ok, padd_ok, !pmul_ok, !below_ok by assumption.
  pose proof (pw_nz e) as E. pose proof (pw_nz d) as G. pose proof (pw_nz (emax e d)) as T.
  transitivity (ev n * pw (esub (emax e d) e) fs * / pw (emax e d) fs
                + ev m * pw (esub (emax e d) d) fs * / pw (emax e d) fs); [field; auto|].
  f_equal.
  - pose proof (emax_l e d fs) as X. pose proof T as U. rewrite X in U |- *. field.
    split; auto. intro Z. apply U. rewrite Z; ring.
  - pose proof (emax_r e d fs) as X. pose proof T as U. rewrite X in U |- *. field.
    split; auto. intro Z. apply U. rewrite Z; ring.
Qed.
Lemma fmul_ok a b : value_of (fmul rs a b) = value_of a * value_of b.
Proof.
  destruct a as [n e], b as [m d]; unfold fmul, value_of; cbn [fst snd].
  rewrite nf_ok, pmul_ok, eadd_ok by assumption. field. split; apply pw_nz.
Qed.
Lemma fopp_ok a : value_of (fopp a) = - value_of a.
Proof. unfold value_of, fopp; simpl. rewrite popp_ok; ring. Qed.
Lemma fpow_ok a n : value_of (fpow rs a n) = power (value_of a) n.
Proof.
  induction n as [|n IH]; [simpl; rewrite constant_ok; apply number_1|].
  destruct n; [simpl; ring|]. cbn [fpow] in *. rewrite fmul_ok, IH; reflexivity.
Qed.
Lemma same_ok a b : same fs rs a b = true -> value_of a = value_of b.
Proof.
  unfold same; intro E. apply is_zero_ok in E.
  assert (Z : value_of (fadd fs rs a (fopp b)) = 0) by (unfold value_of; rewrite E; ring).
  rewrite fadd_ok, fopp_ok in Z.
  transitivity (value_of a + - value_of b + value_of b); [ring|]. rewrite Z; ring.
Qed.
Lemma cut_ok a keep : value_of (cut fs rs a keep) = value_of a.
Proof.
  unfold cut. destruct (same fs rs a _) eqn:E; [symmetry; now apply same_ok | reflexivity].
Qed.
Lemma finv_ok a b : finv fs rs a = Some b -> value_of b = / value_of a.
Proof.
  unfold finv. generalize (fmul rs (below (snd a) fs, []) (inverse fs rs 8 (fst a))).
  intro c; cbv zeta. destruct (same fs rs _ (constant 1)) eqn:E; [|discriminate].
  intro S; apply some_inj in S; subst.
  apply same_ok in E. rewrite fmul_ok, constant_ok, number_1 in E.
  assert (A : value_of a <> 0).
  { intro Z. apply (F_1_neq_0 field_F). rewrite <- E, Z; ring. }
  transitivity (/ value_of a * (value_of a * value_of b)); [field; auto|]. rewrite E; ring.
Qed.

(* Derivations *)
Lemma D_0 v : D v 0 = 0.
Proof.
  pose proof (D_sum v 0 0) as E. replace (0 + 0) with 0 in E by ring.
  transitivity (D v 0 + D v 0 - D v 0); [ring|]. rewrite <- E; ring.
Qed.
Lemma D_1 v : D v 1 = 0.
Proof.
  pose proof (D_product v 1 1) as E. replace (1 * 1) with 1 in E by ring.
  transitivity (D v 1 * 1 + 1 * D v 1 - D v 1); [ring|]. rewrite <- E; ring.
Qed.
Lemma D_opp v a : D v (- a) = - D v a.
Proof.
  pose proof (D_sum v a (- a)) as E. replace (a + - a) with 0 in E by ring. rewrite D_0 in E.
  transitivity (D v a + D v (- a) - D v a); [ring|]. rewrite <- E; ring.
Qed.
Lemma D_inv v a : a <> 0 -> D v (/ a) = - (D v a * / a * / a).
Proof.
  intro A. pose proof (D_product v a (/ a)) as E.
  replace (a * / a) with 1 in E by (field; auto). rewrite D_1 in E.
  transitivity (/ a * (D v a * / a + a * D v (/ a)) - D v a * / a * / a); [field; auto|].
  rewrite <- E; ring.
Qed.
Lemma D_integer v z : D v (integer z) = 0.
Proof.
  assert (P : forall p, D v (integer (Zpos p)) = 0).
  { intro p. induction p using Pos.peano_ind; [apply D_1|].
    rewrite <- Pos.add_1_l, Pos2Z.inj_add, integer_add, D_sum, IHp.
    change (integer 1) with f1. rewrite D_1; ring. }
  destruct z; [apply D_0 | apply P |].
  replace (integer (Z.neg p)) with (- integer (Zpos p)) by
    (change (Z.neg p) with (- Z.pos p)%Z; symmetry; apply (morph_opp integer_morph)).
  rewrite D_opp, P; ring.
Qed.
Lemma D_number v q : D v (number q) = 0.
Proof.
  unfold number. rewrite D_product, D_inv, !D_integer by apply characteristic_0. ring.
Qed.

Fixpoint along (v : nat) (l : list (positive * poly)) : F :=
  match l with [] => 0 | (i, c) :: l => ev c * D v (g i) + along v l end.
Lemma insert_ok v i c l : along v (insert i c l) = ev c * D v (g i) + along v l.
Proof.
  induction l as [|[j d] l IH]; simpl; [reflexivity|].
  destruct (Pos.eqb_spec i j); simpl; [subst; rewrite padd_ok; ring|]. rewrite IH; ring.
Qed.
Lemma merge_ok v a b : along v (merge a b) = along v a + along v b.
Proof.
  unfold merge; induction a as [|[i c] a IH]; simpl; [ring|]. rewrite insert_ok, IH; ring.
Qed.
Lemma partials_ok v p : along v (partials p) = D v (ev p).
Proof.
  induction p as [c | i p IHp q IHq]; simpl; [symmetry; apply D_number|].
  rewrite merge_ok, insert_ok, IHp, D_sum, D_product, <- IHq.
  assert (M : forall l, along v (map (fun x => (fst x, mk i (C 0) (snd x))) l)
                        = g i * along v l).
  { induction l as [|[j d] l IH]; simpl; [ring|]. rewrite mk_ok, IH; simpl.
    rewrite number_00; ring. }
  rewrite M; ring.
Qed.

Variable sl : slopes.
Hypothesis sl_hold : forall v i f, find v i sl = Some f -> D v (g i) = value_of f.
Lemma poly_value c e : value_of (c, e) = ev c * / pw e fs.
Proof. reflexivity. Qed.
Lemma dsum_ok v l : forall f, dsum fs rs sl v l = Some f -> value_of f = along v l.
Proof.
  induction l as [|[i c] l IH]; intros f E; cbn [dsum] in E.
  - apply some_inj in E; subst. rewrite constant_ok. apply number_00.
  - destruct (find v i sl) as [s|] eqn:S; [|discriminate].
    destruct (dsum fs rs sl v l) as [t|]; [|discriminate].
    apply some_inj in E; subst. rewrite fadd_ok, fmul_ok, (IH t eq_refl). simpl.
    rewrite (sl_hold _ _ _ S), poly_value. simpl. field. apply (F_1_neq_0 field_F).
Qed.
Lemma dpoly_ok v p f : dpoly fs rs sl v p = Some f -> value_of f = D v (ev p).
Proof. unfold dpoly; intro E. rewrite (dsum_ok _ _ _ E). apply partials_ok. Qed.
Fixpoint log_slope (v : nat) (e : list nat) (gs : list poly) : F :=
  match e, gs with
  | n :: e, f :: gs => integer (Z.of_nat n) * (D v (ev f) * / ev f) + log_slope v e gs
  | _, _ => 0
  end.
Lemma dlog_ok v e : forall gs f, dlog fs rs sl v e gs = Some f -> value_of f = log_slope v e gs.
Proof.
  induction e as [|n e IH]; intros [|f gs] t E; cbn [dlog] in E.
  1,2,3: try destruct n; apply some_inj in E; subst; rewrite constant_ok; apply number_00.
  destruct n.
  - simpl. rewrite (IH _ _ E). change (integer 0) with f0. ring.
  - destruct (dpoly fs rs sl v f) as [d|] eqn:Df; [|discriminate].
    destruct (dlog fs rs sl v e gs) as [t'|] eqn:L; [|discriminate].
    destruct (finv fs rs (f, [])) as [u|] eqn:U; [|discriminate].
    apply some_inj in E; subst. rewrite fadd_ok, fmul_ok, cut_ok, fmul_ok, constant_ok.
    rewrite (IH _ _ L), (dpoly_ok _ _ _ Df), (finv_ok _ _ U). cbn [log_slope].
    rewrite poly_value. simpl pw.
    replace (ev f * / 1) with (ev f) by (field; apply (F_1_neq_0 field_F)).
    f_equal. f_equal. unfold number; cbn [Qnum Qden]. change (integer 1) with f1.
    field. apply (F_1_neq_0 field_F).
Qed.
Lemma D_power v x n : x <> 0 ->
  D v (power x n) = power x n * (integer (Z.of_nat n) * (D v x * / x)).
Proof.
  intro X. induction n as [|n IH]; [simpl; rewrite D_1; change (integer 0) with f0; ring|].
  cbn [power]. rewrite D_product, IH, Nat2Z.inj_succ, <- Z.add_1_l, integer_add.
  change (integer 1) with f1. field; auto.
Qed.
Lemma D_pw v : forall gs, Forall (fun f => ev f <> 0) gs -> forall e,
  D v (pw e gs) = pw e gs * log_slope v e gs.
Proof.
  induction 1 as [|f l Hf Hl IH]; intros [|n e]; simpl; try (rewrite D_1; ring).
  rewrite D_product, D_power, IH by auto. ring.
Qed.
Lemma dfrac_ok v a f : dfrac fs rs sl v a = Some f -> value_of f = D v (value_of a).
Proof.
  unfold dfrac. destruct (dpoly fs rs sl v (fst a)) as [d|] eqn:P; [|discriminate].
  destruct (dlog fs rs sl v (snd a) fs) as [t|] eqn:L; [|discriminate].
  intro E; apply some_inj in E; subst. rewrite fadd_ok, fopp_ok, !fmul_ok.
  rewrite (dpoly_ok _ _ _ P), (dlog_ok _ _ _ _ L), (poly_value (C 1)). cbn [ev].
  change (value_of a) with (ev (fst a) * / pw (snd a) fs).
  rewrite number_1, D_product, D_inv, D_pw by (auto || apply pw_nz).
  field. apply pw_nz.
Qed.
End Rules.
End Fractions.

Variable nm : positive -> F.
Fixpoint sem (e : ex) : F :=
  match e with
  | Num q => number q
  | Gen i => g i
  | Nam k => nm k
  | Sum a b => sem a + sem b
  | Prod a b => sem a * sem b
  | Neg a => - sem a
  | Inv a => / sem a
  | Pow a n => power (sem a) n
  | Der v a => D v (sem a)
  end.
Record good (fs : list poly) (s : state) : Prop := Good {
  good_names : forall k f, find 0 k (names s) = Some f -> nm k = value_of fs f;
  good_rels : Forall holds (rels s);
  good_gens : forall v i f, find v i (gens s) = Some f -> D v (g i) = value_of fs f;
  good_rates : forall v k f, find v k (rates s) = Some f -> D v (nm k) = value_of fs f }.
Section Steps.
Variable fs : list poly.
Hypothesis not_zero : Forall (fun f => ev f <> 0) fs.
Lemma eval_ok s : good fs s -> forall e f, eval fs s e = Some f -> value_of fs f = sem e.
Proof.
  intro G; pose proof (good_rels _ _ G) as R.
  induction e as [q|i|k|a IHa b IHb|a IHa b IHb|a IHa|a IHa|a IHa n|v a IHa]; intros f E;
    cbn [eval] in E.
  - apply some_inj in E; subst. apply constant_ok.
  - apply some_inj in E; subst. rewrite poly_value; simpl. rewrite number_00, number_1.
    field. apply (F_1_neq_0 field_F).
  - symmetry; now apply (good_names _ _ G).
  - destruct (eval fs s a) as [x|]; [|discriminate]. destruct (eval fs s b) as [y|]; [|discriminate].
    apply some_inj in E; subst. rewrite fadd_ok by assumption.
    now rewrite (IHa x eq_refl), (IHb y eq_refl).
  - destruct (eval fs s a) as [x|]; [|discriminate]. destruct (eval fs s b) as [y|]; [|discriminate].
    apply some_inj in E; subst. rewrite fmul_ok by assumption.
    now rewrite (IHa x eq_refl), (IHb y eq_refl).
  - destruct (eval fs s a) as [x|]; [|discriminate]. apply some_inj in E; subst.
    rewrite fopp_ok. now rewrite (IHa x eq_refl).
  - destruct (eval fs s a) as [x|]; [|discriminate].
    rewrite (finv_ok _ not_zero _ R _ _ E). now rewrite (IHa x eq_refl).
  - destruct (eval fs s a) as [x|]; [|discriminate]. apply some_inj in E; subst.
    rewrite fpow_ok by assumption. now rewrite (IHa x eq_refl).
  - assert (X : forall x, eval fs s a = Some x -> dfrac fs (rels s) (gens s) v x = Some f ->
                          value_of fs f = D v (sem a)).
    { intros x A P. rewrite <- (IHa x A). now apply (dfrac_ok _ not_zero _ R _ (good_gens _ _ G)). }
    destruct a; try (destruct (eval fs s _) as [x|]; [|discriminate]; now apply (X x)).
    destruct (find v i (rates s)) as [x|] eqn:N.
    + apply some_inj in E; subst. symmetry; now apply (good_rates _ _ G).
    + destruct (eval fs s _) as [x|]; [|discriminate]; now apply (X x).
Qed.
Lemma cut_value_ok s e keep f : good fs s -> value fs s e keep = Some f -> value_of fs f = sem e.
Proof.
  intros G E. unfold value in E. destruct (eval fs s e) as [x|] eqn:X; [|discriminate].
  destruct keep as [keep|]; apply some_inj in E; subst; [|now apply (eval_ok s)].
  rewrite cut_ok by (assumption || apply (good_rels _ _ G)). now apply (eval_ok s).
Qed.
Definition assumed (t : step) : Prop :=
  match t with
  | Def k e _ => nm k = sem e
  | Rel i k e => power (g i) (S k) = sem e
  | Slo v i e _ => D v (g i) = sem e
  | Rat _ _ _ _ | Zer _ => True
  end.
Definition shown (t : step) : Prop :=
  match t with
  | Rat v k e _ => D v (nm k) = sem e
  | Zer e => sem e = 0
  | _ => True
  end.
Lemma found v i w j f l h : find v i ((w, j, f) :: l) = Some h ->
  (v = w /\ i = j /\ h = f) \/ find v i l = Some h.
Proof.
  simpl. destruct (Nat.eqb_spec v w), (Pos.eqb_spec i j); simpl; auto.
  left; repeat split; auto; congruence.
Qed.
Lemma pw_zeros d l : forallb (Nat.eqb 0) d = true -> pw d l = 1.
Proof.
  revert l; induction d as [|n d IH]; intros [|f l] E; simpl in *; try reflexivity.
  destruct n; [|discriminate]. simpl in E |- *.
  rewrite IH by assumption; ring.
Qed.
Lemma advance_ok s t s' :
  good fs s -> assumed t -> advance fs s t = Some s' -> good fs s' /\ shown t.
Proof.
  intros G A E. destruct t as [k e keep|i k e|v i e keep|v k e keep|e]; cbn [advance] in E.
  - destruct (value fs s e keep) as [x|] eqn:V; [|discriminate]. apply some_inj in E; subst.
    split; [|exact I]. destruct G as [G1 G2 G3 G4]; split; auto. cbn [names]. intros j f N.
    destruct (found _ _ _ _ _ _ _ N) as [(_ & -> & ->)|N']; [|auto].
    simpl in A; rewrite A. symmetry. eapply cut_value_ok; [|exact V]. now split.
  - destruct (value fs s e (Some [])) as [[n d]|] eqn:V; [|discriminate].
    destruct (forallb (Nat.eqb 0) d) eqn:Z; [|discriminate]. apply some_inj in E; subst.
    apply cut_value_ok in V; [|assumption]. rewrite poly_value, pw_zeros in V by assumption.
    split; [|exact I]. destruct G as [G1 G2 G3 G4]; split; auto. cbn [rels]. constructor; auto.
    simpl in A |- *. rewrite A, <- V. field. apply (F_1_neq_0 field_F).
  - destruct (value fs s e keep) as [x|] eqn:V; [|discriminate]. apply some_inj in E; subst.
    split; [|exact I]. destruct G as [G1 G2 G3 G4]; split; auto. cbn [gens]. intros w j f N.
    destruct (found _ _ _ _ _ _ _ N) as [(-> & -> & ->)|N']; [|auto].
    simpl in A; rewrite A. symmetry. eapply cut_value_ok; [|exact V]. now split.
  - destruct (eval fs s (Der v (Nam k))) as [a|] eqn:V; [|discriminate].
    destruct (value fs s e keep) as [b|] eqn:W; [|discriminate].
    destruct (same fs (rels s) a b) eqn:S; [|discriminate]. apply some_inj in E; subst.
    apply same_ok in S; [|assumption|apply (good_rels _ _ G)].
    apply (eval_ok s G) in V. apply (cut_value_ok s) in W; [|assumption]. simpl in V.
    split; [|simpl; congruence]. destruct G as [G1 G2 G3 G4]; split; auto. cbn [rates].
    intros w j f N. destruct (found _ _ _ _ _ _ _ N) as [(-> & -> & ->)|N']; [congruence|auto].
  - destruct (eval fs s e) as [[n d]|] eqn:V; [|discriminate].
    destruct (is_zero n) eqn:Z; [|discriminate]. apply some_inj in E; subst.
    split; [assumption|]. simpl. rewrite <- (eval_ok _ G _ _ V), poly_value, (is_zero_ok _ Z). ring.
Qed.
Fixpoint all_assumed (l : list step) : Prop :=
  match l with
  | [] => True
  | (Rat _ _ _ _ | Zer _) :: l => all_assumed l
  | t :: l => assumed t /\ all_assumed l
  end.
Fixpoint all_shown (l : list step) : Prop :=
  match l with
  | [] => True
  | (Rat _ _ _ _ | Zer _) as t :: l => shown t /\ all_shown l
  | _ :: l => all_shown l
  end.
Lemma run_ok l : forall s s', good fs s -> all_assumed l -> run fs s l = Some s' -> all_shown l.
Proof.
  induction l as [|t l IH]; intros s s' G A E; [exact I|].
  cbn [run] in E. destruct (advance fs s t) as [r|] eqn:V; [|discriminate].
  assert (T : assumed t /\ all_assumed l) by (destruct t; simpl in A |- *; tauto).
  destruct T as [T1 T2]. destruct (advance_ok s t r G T1 V) as [G' S].
  specialize (IH r s' G' T2 E). destruct t; simpl in *; auto.
Qed.
End Steps.
Lemma good_start fs : good fs start.
Proof. split; simpl; try discriminate. constructor. Qed.
Fixpoint all_nonzero (ds : list ex) : Prop :=
  match ds with [] => True | d :: ds => sem d <> 0 /\ all_nonzero ds end.
Theorem accepted ds l :
  accepts ds l = true -> all_nonzero ds -> all_assumed l -> all_shown l.
Proof.
  unfold accepts. intros E N A. destruct (polynomials ds) as [fs|] eqn:P; [|discriminate].
  destruct (run fs start l) as [s|] eqn:R; [|discriminate].
  refine (run_ok fs _ l start s (good_start fs) A R).
  clear R E A. revert fs P N; induction ds as [|d ds IH]; intros fs P N; cbn [polynomials] in P.
  - apply some_inj in P; subst; constructor.
  - destruct (eval [] start d) as [[p x]|] eqn:V; [|discriminate].
    destruct (polynomials ds) as [r|]; [|discriminate]. apply some_inj in P; subst.
    destruct N as [N1 N2]. constructor; [|now apply IH].
    apply (eval_ok [] (Forall_nil _) start (good_start [])) in V. intro Z. apply N1.
    rewrite <- V, poly_value, Z; ring.
Qed.
End Meaning.
Definition listed (l : list F) (i : positive) : F := nth (Pos.to_nat i - 1) l 0.
